// Changes between the light and the dark colour scheme.
(() => {
  "use strict";
  const [root, button] = [document.documentElement, document.getElementById("theme")];
  const night = matchMedia("(prefers-color-scheme: dark)");
  const isDark = () => (root.style.colorScheme ? root.style.colorScheme === "dark" : night.matches);
  const label = () => { button.textContent = isDark() ? "Light" : "Dark"; };
  button.addEventListener("click", () => {
    root.style.colorScheme = isDark() ? "light" : "dark";
    label();
    window.dispatchEvent(new Event("themechange"));
  });
  night.addEventListener("change", label);
  label();
})();
