// One metric's plots at a time.
const shownMetric = document.getElementById("plot-metric");
if (shownMetric) {
  const show = () => {
    for (const figure of document.querySelectorAll("[data-metric]")) {
      figure.hidden = figure.dataset.metric !== shownMetric.value;
    }
  };
  shownMetric.addEventListener("change", show);
  show();
}
