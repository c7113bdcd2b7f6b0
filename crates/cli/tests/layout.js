// Measures the layout of a page from inside, as a reader sees it, and sends the faults to the page
// that holds it in a frame.
addEventListener("load", () => {
  const seen = { faults: [], charts: 0, texts: 0, words: 0, tables: 0 };
  const fault = (kind, text) => seen.faults.push(`${kind}: ${String(text).trim().replace(/\s+/g, " ").slice(0, 90)}`);
  // Rounding of layout (pixels).
  const SLACK = 1.5;

  // Red, green, blue and opacity of a computed colour.
  const rgb = (colour) => {
    const numbers = (colour.match(/[\d.]+/g) || []).map(Number);
    return numbers.length >= 3 ? [numbers[0], numbers[1], numbers[2], numbers.length > 3 ? numbers[3] : 1] : null;
  };
  const isInk = (colour) => {
    const found = rgb(colour);
    return found !== null && found[3] > 0.05 && Math.max(...found.slice(0, 3)) - Math.min(...found.slice(0, 3)) > 30;
  };
  const luminance = ([r, g, b]) => {
    const linear = (c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4);
    return 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  };
  const contrast = (one, other) => {
    const [low, high] = [luminance(one), luminance(other)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  };
  const scrolls = (element) => ["auto", "scroll"].includes(getComputedStyle(element).overflowX);

  function chart(svg) {
    const frame = svg.getBoundingClientRect();
    const texts = [...svg.querySelectorAll("text")].filter((text) => text.textContent.trim() !== "");
    if (frame.width < 50 || frame.height < 50) fault("small picture", `${frame.width} × ${frame.height}`);
    if (/NaN|Infinity/.test(svg.outerHTML)) fault("broken picture", svg.textContent);
    const boxes = texts.map((text) => [text, text.getBoundingClientRect()]);
    for (const [text, box] of boxes) {
      seen.texts += 1;
      const isInside = box.left >= frame.left - SLACK && box.right <= frame.right + SLACK;
      if (!isInside || box.top < frame.top - SLACK || box.bottom > frame.bottom + SLACK) fault("cut label", text.textContent);
    }
    // Labels over each other, by more than a third of the smaller one.
    boxes.forEach(([one, a], index) => {
      for (const [other, b] of boxes.slice(index + 1)) {
        const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (wide > 0 && high > 0 && wide * high > 0.33 * Math.min(a.width * a.height, b.width * b.height)) {
          fault("labels over each other", `${one.textContent} | ${other.textContent}`);
        }
      }
    });
    // A picture with numbers at its axes is a chart: its data are coloured marks wider than those
    // of a legend.
    const numbers = texts.filter((text) => /^[-−]?[\d.]+(e-?\d+)?°?$/.test(text.textContent.trim()));
    if (numbers.length < 4) return;
    seen.charts += 1;
    const ground = rgb(getComputedStyle(svg.closest("figure") || document.body).backgroundColor);
    for (const text of texts) {
      const ink = rgb(getComputedStyle(text).fill);
      if (ink && ground && contrast(ink, ground) < 1.9) fault("faint label", text.textContent);
    }
    // The same number twice along an axis.
    for (const side of ["x", "y"]) {
      const at = numbers.map((text) => `${side} ${Math.round(Number(text.getAttribute(side)))} ${text.textContent.trim()}`);
      const twice = at.find((place, index) => at.indexOf(place) !== index);
      if (twice) fault("number twice at an axis", twice);
    }
    let [left, right] = [Infinity, -Infinity];
    for (const mark of svg.querySelectorAll("path, polyline, polygon, line, circle, rect, ellipse")) {
      if (mark.closest("clipPath, defs")) continue;
      const style = getComputedStyle(mark);
      if (!(isInk(style.stroke) || isInk(style.fill)) || style.visibility === "hidden") continue;
      const box = mark.getBoundingClientRect();
      [left, right] = [Math.min(left, box.left), Math.max(right, box.right)];
    }
    if (!(Math.min(right, frame.right) - Math.max(left, frame.left) > 0.1 * frame.width)) fault("empty chart", svg.textContent);
  }

  // A word on two lines: its characters have different heights. It may break at a hyphen, slash or bar.
  function words(node) {
    const range = document.createRange();
    for (const match of node.data.matchAll(/[^\s\-–—\/|·_.?&=:]+/g)) {
      seen.words += 1;
      range.setStart(node, match.index);
      range.setEnd(node, match.index + match[0].length);
      const tops = [...range.getClientRects()].filter((box) => box.width > 0).map((box) => box.top);
      if (tops.length > 1 && Math.max(...tops) - Math.min(...tops) > 4) fault("broken word", match[0]);
    }
  }

  function measure() {
    const root = document.documentElement;
    const visible = root.clientWidth;
    if (root.scrollWidth > visible + SLACK) fault("wide page", `${root.scrollWidth} of ${visible}`);
    document.querySelectorAll("main svg").forEach(chart);
    const walker = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT);
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
      if (!node.parentElement.closest("svg, script, style, details:not([open])")) words(node);
    }
    seen.tables = document.querySelectorAll("main table").length;
    // Text that leaves its box, unless the box scrolls.
    for (const element of document.querySelectorAll("main *")) {
      if (element.closest("svg, script, details:not([open])") || scrolls(element)) continue;
      if (element.clientWidth > 0 && element.scrollWidth > element.clientWidth + SLACK) fault("overflow", `${element.tagName} ${element.textContent}`);
      const box = element.getBoundingClientRect();
      let frame = element.parentElement;
      while (frame && !scrolls(frame)) frame = frame.parentElement;
      if (!frame && box.width > 0 && box.right > visible + SLACK) fault("beyond the page", `${element.tagName} ${element.textContent}`);
    }
    const [ink, ground] = [getComputedStyle(document.body).color, getComputedStyle(document.body).backgroundColor].map(rgb);
    if (contrast(ink, ground) < 7) fault("faint text", `${ink} on ${ground}`);
    seen.dark = luminance(ground) < 0.2;
    faults.forEach((text) => fault("console", text));
  }

  try {
    measure();
  } catch (error) {
    fault("probe", error.stack || error);
  }
  seen.faults = [...new Set(seen.faults)];
  parent.postMessage({ name: window.name, seen }, "*");
});
