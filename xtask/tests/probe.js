// Examines a page from inside, as a reader sees it, and stores the results.
addEventListener("load", async () => {
  const later = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
  const pixels = (canvas) => {
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
    copy.drawImage(canvas, 0, 0);
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
    return new Uint32Array(data.buffer);
  };
  // Share of the pixels not in the most frequent colour; number of colours that cover a thousandth or more each.
  const look = (canvas) => {
    const counts = new Map();
    const all = pixels(canvas);
    for (const pixel of all) counts.set(pixel, (counts.get(pixel) || 0) + 1);
    const sorted = [...counts.values()].sort((a, b) => b - a);
    return { share: 1 - sorted[0] / all.length, colours: sorted.filter((n) => n > all.length / 1000).length };
  };
  const differ = (one, other) => one.length !== other.length || one.some((pixel, index) => pixel !== other[index]);
  const seen = {};
  try {
    const canvases = [...document.querySelectorAll("canvas")];
    seen.canvases = canvases.map(look);
    const slider = document.querySelector("input[type=range]");
    const slide = (value) => {
      slider.value = value;
      slider.dispatchEvent(new Event("input"));
    };
    slide(0);
    const first = canvases.map(pixels);
    slide(9000);
    seen.moved = canvases.map((canvas, index) => differ(pixels(canvas), first[index]));
    slide(0);
    seen.back = canvases.map((canvas, index) => !differ(pixels(canvas), first[index]));
    const play = document.querySelector(".controls button");
    play.click();
    // A busy machine draws the first frame late.
    for (let tries = 0; tries < 80 && Number(slider.value) === 0; tries += 1) await later(200);
    seen.played = Number(slider.value);
    play.click();
    const stopped = slider.value;
    await later(200);
    seen.paused = slider.value === stopped;
    const ground = () => getComputedStyle(document.body).backgroundColor;
    const day = ground();
    document.getElementById("theme").click();
    seen.night = [day, ground()];
    seen.redrawn = canvases.map((canvas) => look(canvas).colours > 1);
    seen.figures = [...document.querySelectorAll("figure svg")].map((svg) => {
      const box = svg.getBoundingClientRect();
      return { width: box.width, height: box.height, text: svg.textContent, broken: /NaN|Infinity/.test(svg.outerHTML) };
    });
    seen.overflow = document.documentElement.scrollWidth - document.documentElement.clientWidth;
    seen.fetched = performance.getEntriesByType("resource").map((entry) => entry.name);
  } catch (error) {
    faults.push(String(error));
  }
  seen.faults = faults;
  const element = document.createElement("script");
  element.type = "application/json";
  element.id = "seen";
  element.textContent = JSON.stringify(seen).replaceAll("<", "\\u003c");
  document.body.append(element);
});
