// Puts the page together.
"use strict";

headSection();
modelSection();
hypothesesSection();
planSection();
certificateSection();
tablesSection();
energiesSection();
const fieldsShown = fieldsSection();
studySection();
stabilitySection();
if (report.source) sourceSection();
fieldsShown.then(() => {
  document.body.dataset.readyAt = performance.now(); // milliseconds since the page was asked for
  document.body.dataset.ready = "yes";
});
