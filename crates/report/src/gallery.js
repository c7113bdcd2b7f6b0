// Shows the cards that have all words of the search and the chosen subject.
(() => {
  "use strict";
  const search = document.getElementById("search");
  const found = document.getElementById("found");
  const buttons = [...document.querySelectorAll(".subjects button")];
  const cards = [...document.querySelectorAll(".card")].map((card) => ({
    card,
    subjects: card.dataset.subjects.split("|"),
    text: `${card.textContent} ${card.dataset.words}`.toLowerCase(),
  }));
  let subject = "";
  const show = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let count = 0;
    for (const { card, subjects, text } of cards) {
      const fits = words.every((word) => text.includes(word))
        && (!subject || subjects.includes(subject));
      card.hidden = !fits;
      count += fits ? 1 : 0;
    }
    found.textContent = `${count} of ${cards.length} shown`;
  };
  for (const button of buttons) {
    button.addEventListener("click", () => {
      subject = button.dataset.subject;
      for (const other of buttons) other.setAttribute("aria-pressed", String(other === button));
      show();
    });
  }
  search.addEventListener("input", show);
  show();
})();
