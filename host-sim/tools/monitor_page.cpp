#include <fmt/format.h>

#include <string>

#include "host-sim/report/assets.hpp"
#include "host-sim/tools/monitor_views.hpp"

namespace plenum::host::tools {
namespace {

constexpr const char* kStyle = R"(
body { max-width: 1400px; padding-top: 1.25rem; }
header { display: flex; flex-wrap: wrap; gap: .5rem 1.5rem; align-items: baseline; }
header h1 { margin: 0; font-size: 1.4rem; }
#state { font-weight: 600; }
#fault.stands, #link.lost, #state.lost { color: var(--missed); font-weight: 600; }
.live { height: 300px; margin: .75rem 0; background: var(--card); border: 1px solid var(--line); border-radius: 8px; }
)";

// The last minute of every chamber, in three charts that share their time.
constexpr const char* kScript = R"(
'use strict';
const shown_s = 60;
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
if (matchMedia('(prefers-color-scheme: dark)').matches) document.documentElement.dataset.theme = 'dark';
const chart_of = (id, title, unit) => {
  const chart = echarts.init(document.getElementById(id));
  const line = {lineStyle: {color: css('--line')}};
  chart.setOption({
    animation: false, title: {text: title.replace('UNIT', unit), left: 12, top: 8, textStyle: {fontSize: 14, color: css('--ink')}},
    legend: {right: 12, top: 8, icon: 'roundRect', itemWidth: 20, itemHeight: 8, textStyle: {color: css('--soft')},
             tooltip: {show: true, formatter: 'a click shows or hides all curves of the chamber'}},
    grid: {left: 64, right: 20, top: 44, bottom: 36},
    tooltip: {trigger: 'axis', valueFormatter: (value) => value == null ? '-' : value.toFixed(2) + ' ' + unit},
    xAxis: {type: 'value', min: 'dataMin', max: 'dataMax', axisLine: line, splitLine: {show: false},
            axisLabel: {color: css('--soft'), formatter: '{value} s', showMinLabel: false, showMaxLabel: false}}, // of ends that move
    yAxis: {type: 'value', scale: true, axisLabel: {color: css('--soft')}, splitLine: {lineStyle: {color: css('--grid')}}},
  });
  addEventListener('resize', () => chart.resize());
  return chart;
};
const charts = {pressure: chart_of('pressure', 'Pressure, absolute [UNIT] (dashed: set point)', 'kPa'),
                command: chart_of('command', 'Valve command [UNIT]', 'V'), volume: chart_of('volume', 'Volume [UNIT]', 'mL')};
echarts.connect(Object.values(charts));
// What they show is of the stream alone: a monitor that was started anew may watch another board.
const rows = [];
let chambers = 0;
const series = (key, {dashed = false, steps = false} = {}) => Array.from({length: chambers}, (_, c) => ({
  name: 'chamber ' + (c + 1), type: 'line', step: steps ? 'end' : false, showSymbol: false, sampling: 'lttb', emphasis: {disabled: true},
  color: css('--c' + c), lineStyle: {width: dashed ? 1 : 1.75, type: dashed ? 'dashed' : 'solid'},
  data: rows.map((row) => [row.t, row.chamber[c][key]]),
}));
// A chart that nothing on the bus feeds says so instead of staying blank.
const hint = (chart, key) => chart.setOption({graphic: {id: 'hint', type: 'text', left: 'center', top: 'middle', silent: true,
  style: {fill: css('--soft'), fontSize: 14,
          text: rows.some((row) => row.chamber.some((c) => c[key] != null)) ? '' : 'not on the bus: started with --stream, the monitor asks the board for it'}}});
const draw = () => {
  hint(charts.pressure, 'actual_kPa');
  hint(charts.command, 'command_V');
  hint(charts.volume, 'volume_mL');
  const show = (chart, lines) => chart.setOption({series: lines}, {replaceMerge: 'series'});
  show(charts.pressure, [...series('actual_kPa'), ...series('setpoint_kPa', {dashed: true, steps: true})]);
  show(charts.command, series('command_V', {steps: true}));
  show(charts.volume, series('volume_mL'));
};
const say = (id, text, bad, name) => {
  const element = document.getElementById(id);
  element.textContent = text;
  element.classList.toggle(name, bad);
};
let drawing = false;
const events = new EventSource('/events');
events.onmessage = (event) => {
  const {timestamp, ...nodes} = JSON.parse(event.data);
  const [[name, board]] = Object.entries(nodes);
  chambers = Object.keys(board).filter((key) => key.startsWith('chamber')).length;
  document.getElementById('board').textContent = name.replace('node', 'Node ');
  document.title = name.replace('node', 'Plenum node ');
  rows.push({t: Math.round(timestamp * 1000) / 1000, chamber: Array.from({length: chambers}, (_, c) => board['chamber' + (c + 1)])});
  while (rows.length > 0 && rows[0].t < timestamp - shown_s) rows.shift();
  say('state', board.silent_s !== null ? 'silent for ' + board.silent_s.toFixed(1) + ' s'
                                       : (board.state ?? 'no status word') + ' · ' + (board.nmt ?? 'no heartbeat'), board.silent_s !== null, 'lost');
  say('fault', board.fault ?? 'no fault', board.fault !== null, 'stands');
  document.getElementById('frames').textContent = board.frames + ' frames';
  document.documentElement.dataset.events = rows.length;
  if (!drawing) { drawing = true; requestAnimationFrame(() => { drawing = false; draw(); }); }
};
events.onopen = () => {
  rows.length = 0;
  say('link', 'live', false, 'lost');
};
events.onerror = () => say('link', 'the monitor does not answer', true, 'lost');
)";

}  // namespace

std::string monitor_page() {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" "
      "href=\"data:,\">\n"
      "<title>Plenum</title>\n<style>{}{}</style>\n</head>\n<body>\n"
      "<header><h1 id=\"board\">Plenum</h1><span id=\"state\">waiting for the board</span><span "
      "id=\"fault\"></span>"
      "<span id=\"frames\"></span><span id=\"link\"></span></header>\n"
      "<div id=\"pressure\" class=\"live\"></div>\n<div id=\"command\" class=\"live\"></div>\n"
      "<div id=\"volume\" class=\"live\"></div>\n"
      "<script>{}</script>\n<script>{}</script>\n</body>\n</html>\n",
      report::page_style(), kStyle, report::echarts_script(), kScript);
}

}  // namespace plenum::host::tools
