"use strict";
// Figures become live where Bokeh runs; on paper, and without scripts, the drawn ones stay.
document.documentElement.classList.add("scripted");
function inside(node, found) {  // every element, through the shadow roots
  for (const one of node.querySelectorAll("*")) {
    found(one);
    if (one.shadowRoot) inside(one.shadowRoot, found);
  }
}
async function draw(figure) {
  const { document: doc, item } = JSON.parse(figure.querySelector("script").textContent);
  await Bokeh.embed.embed_items({ [item.docid]: doc }, [item]);
  // a finger that moves up or down scrolls the page, not the figure
  setTimeout(() => inside(figure, (one) => {
    if (getComputedStyle(one).touchAction === "none") one.style.touchAction = "pan-y";
  }), 300);
}
const pending = new IntersectionObserver((seen) => {
  for (const one of seen) if (one.isIntersecting) { pending.unobserve(one.target); draw(one.target); }
}, { rootMargin: "600px" });
document.querySelectorAll(".live").forEach((one) => pending.observe(one));
