// Draws the curves of the report from the JSON block of the page. All numbers come as they are to be shown.
(function () {
  "use strict";
  var drawings = JSON.parse(document.getElementById("drawings").textContent);
  var dashes = ["solid", "dash", "dot", "dashdot"];
  var marks = ["circle", "square", "diamond", "cross", "triangle-up", "x"];

  function withAlpha(colour, alpha) {
    var n = parseInt(colour.slice(1), 16);
    return "rgba(" + (n >> 16) + "," + ((n >> 8) & 255) + "," + (n & 255) + "," + alpha + ")";
  }

  // The band as closed outlines, one for each stretch without a gap.
  function outline(t) {
    var x = [], y = [], start = 0;
    function close(end) {
      for (var i = start; i < end; i++) { x.push(t.x[i]); y.push(t.upper[i]); }
      for (i = end - 1; i >= start; i--) { x.push(t.x[i]); y.push(t.lower[i]); }
      if (end > start) { x.push(t.x[start], null); y.push(t.upper[start], null); }
    }
    for (var i = 0; i <= t.x.length; i++) {
      if (i === t.x.length || t.x[i] === null || t.lower[i] === null || t.upper[i] === null) {
        close(i);
        start = i + 1;
      }
    }
    return { x: x, y: y };
  }

  function difference(a, b) {
    return a.map(function (v, i) { return v === null || b[i] === null ? null : v - b[i]; });
  }

  function traces(drawing) {
    var all = [];
    drawing.traces.forEach(function (t, i) {
      var colour = drawing.colours[i % drawing.colours.length];
      var round = Math.floor(i / drawing.colours.length);
      var what = t.lower && t.band ? " (" + (t.points ? "bars" : "band") + ": " + t.band + ")" : "";
      var trace = { type: "scatter", name: t.name + what, x: t.x, y: t.y, legendgroup: "g" + i, connectgaps: false };
      if (t.points) {
        trace.mode = "markers";
        trace.marker = { color: colour, size: 6, symbol: marks[i % marks.length] };
        if (t.lower) {
          trace.error_y = {
            type: "data", symmetric: false, array: difference(t.upper, t.y), arrayminus: difference(t.y, t.lower),
            color: colour, thickness: 1.2, width: 3
          };
        }
      } else {
        trace.mode = "lines";
        trace.line = { color: colour, width: 1.7, dash: dashes[round % dashes.length] };
        if (t.lower) {
          var band = outline(t);
          all.push({
            type: "scatter", mode: "lines", x: band.x, y: band.y, legendgroup: "g" + i, showlegend: false,
            fill: "toself", fillcolor: withAlpha(colour, 0.18), line: { width: 0 }, hoverinfo: "skip"
          });
        }
      }
      all.push(trace);
    });
    return all;
  }

  function axis(title, logarithmic) {
    return {
      title: { text: title, standoff: 10 }, type: logarithmic ? "log" : "linear", automargin: true,
      showline: true, linecolor: "#51606e", mirror: true, ticks: "outside", tickcolor: "#51606e",
      gridcolor: "#e3e8ed", zeroline: !logarithmic, zerolinecolor: "#b4c0cb", exponentformat: "power",
      minor: logarithmic ? { ticks: "outside", ticklen: 3, showgrid: true, gridcolor: "#f1f4f6" } : undefined
    };
  }

  function layout(drawing) {
    return {
      font: { family: "system-ui, 'Segoe UI', Roboto, 'Liberation Sans', Arial, sans-serif", size: 13, color: "#1b2733" },
      margin: { l: 70, r: 15, t: 15, b: 50 }, paper_bgcolor: "#fff", plot_bgcolor: "#fff", hovermode: "closest",
      showlegend: true, legend: { orientation: "h", x: 0, y: 1.02, xanchor: "left", yanchor: "bottom" },
      xaxis: axis(drawing.x, drawing.logarithmic_x), yaxis: axis(drawing.y, drawing.logarithmic), autosize: true
    };
  }

  drawings.forEach(function (drawing) {
    Plotly.newPlot(drawing.place, traces(drawing), layout(drawing), {
      responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "sendChartToCloud"],
      showSendToCloud: false, plotlyServerURL: "",  // measured data stay in this page
      toImageButtonOptions: { format: "svg", filename: drawing.place }
    });
  });

  // A printed page is narrower than the window: draw at its proportions (the style sheet knows them) and let the
  // drawing scale to the paper; and back again.
  var paper = { width: 685, height: 262 };
  function resize(size, box) {
    drawings.forEach(function (drawing) {
      Plotly.relayout(drawing.place, size);
      document.getElementById(drawing.place).querySelectorAll(".main-svg").forEach(function (svg) {
        if (box) { svg.setAttribute("viewBox", box); } else { svg.removeAttribute("viewBox"); }
      });
    });
  }
  window.addEventListener("beforeprint", function () {
    resize({ autosize: false, width: paper.width, height: paper.height }, "0 0 " + paper.width + " " + paper.height);
  });
  window.addEventListener("afterprint", function () {
    resize({ autosize: true, width: null, height: null }, null);
  });
})();
