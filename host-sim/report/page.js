// Draws the charts of a page from the data beside it. All text reaches the page through ECharts' own text drawing or
// through encodeHTML; nothing here reads the network.
(() => {
  'use strict';

  const root = document.documentElement;
  const page = JSON.parse(document.getElementById('page-data').textContent);
  const vector = location.hash === '#svg';
  const touch = matchMedia('(pointer: coarse)').matches;
  const darkSystem = matchMedia('(prefers-color-scheme: dark)');
  const palette_size = 8;
  const printed_width = 660; // px: what A4 leaves between its margins and a figure's own

  // ---- numbers

  const arrays = page.arrays.map((array) => {
    if (!('f32' in array)) return Float64Array.from({length: array.count}, (_, i) => array.from + array.step * i);
    const text = atob(array.f32);
    const bytes = new DataView(new ArrayBuffer(text.length));
    for (let i = 0; i < text.length; ++i) bytes.setUint8(i, text.charCodeAt(i));
    return Float64Array.from({length: text.length / 4}, (_, i) => bytes.getFloat32(4 * i, true));
  });

  const interleaved = (x, y) => {
    const flat = new Float64Array(2 * x.length);
    for (let i = 0; i < x.length; ++i) {
      flat[2 * i] = x[i];
      flat[2 * i + 1] = y[i];
    }
    return flat;
  };

  // Index of the value next to `at` in rising values.
  const nearest = (values, at) => {
    let low = 0, high = values.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (values[middle] <= at) low = middle; else high = middle;
    }
    return at - values[low] <= values[high] - at ? low : high;
  };

  const number = (value) => {
    if (!Number.isFinite(value)) return '–';
    const size = Math.abs(value);
    return size !== 0 && (size < 1e-4 || size >= 1e7) ? value.toExponential(3) : String(Number(value.toPrecision(5)));
  };

  const with_unit = (value, axis) => number(value) + (axis.unit ? ' ' + axis.unit : '');
  const axis_name = (axis) => axis.unit ? `${axis.quantity} (${axis.unit})` : axis.quantity;
  const text = echarts.format.encodeHTML;

  // ---- colours: a name keeps its colour across the page unless it is taken within the chart

  const home_colour = new Map();
  const colours_of = (names) => {
    const taken = new Set();
    const colours = new Map();
    for (const name of names) {
      if (colours.has(name)) continue;
      let colour = home_colour.get(name);
      if (colour === undefined || taken.has(colour)) {
        colour = 0;
        while (taken.has(colour) && colour < palette_size - 1) ++colour;
        if (!home_colour.has(name)) home_colour.set(name, colour);
      }
      taken.add(colour);
      colours.set(name, colour);
    }
    return colours;
  };

  const inks = () => {
    const style = getComputedStyle(root);
    const of = (name) => style.getPropertyValue('--' + name).trim();
    return {
      text: of('ink'), soft: of('soft'), line: of('line'), grid: of('grid'), faint: of('faint'), card: of('card'),
      accent: of('accent'), font: getComputedStyle(document.body).fontFamily,
      palette: Array.from({length: palette_size}, (_, i) => of('c' + i)),
    };
  };

  // ---- parts that charts share

  const frame = (ink) => ({
    animation: false,
    textStyle: {fontFamily: ink.font, color: ink.text},
    tooltip: {
      confine: true, backgroundColor: ink.card, borderColor: ink.line, padding: [6, 10],
      textStyle: {color: ink.text, fontSize: 12, fontFamily: ink.font},
      axisPointer: {lineStyle: {color: ink.soft}, shadowStyle: {opacity: .15}},
    },
    legend: {
      type: 'scroll', top: 0, left: 0, right: 8, padding: [4, 8], itemWidth: 20, itemHeight: 8, itemGap: 14,
      textStyle: {color: ink.text, fontSize: 12}, pageTextStyle: {color: ink.soft},
      pageIconColor: ink.accent, pageIconInactiveColor: ink.faint, inactiveColor: ink.faint,
    },
  });

  const axis_form = (ink) => ({
    axisLine: {onZero: false, lineStyle: {color: ink.faint}},
    axisTick: {lineStyle: {color: ink.faint}},
    axisLabel: {color: ink.soft, fontSize: 11, hideOverlap: true},
    nameTextStyle: {color: ink.soft, fontSize: 12},
    splitLine: {lineStyle: {color: ink.grid}},
  });

  const value_axis = (axis, ink) => {
    const form = axis_form(ink);
    return {
      ...form,
      // an end of the axis that is the data's own has all the digits of a 32-bit number
      axisLabel: {...form.axisLabel, formatter: number},
      type: axis.log ? 'log' : 'value', scale: true, name: axis_name(axis), min: axis.min, max: axis.max,
    };
  };

  // The ends of curves are the data's own, out to the round number next to them: 59.99 is drawn to 60.
  const end = (value, span, round) => {
    const step = 10 ** Math.floor(Math.log10(span)) / 10;
    const outward = round(value / step) * step;
    return Math.abs(outward - value) <= 0.01 * span ? outward : value;
  };
  const data_ends = {
    min: ({min, max}) => end(min, max - min, Math.floor), max: ({min, max}) => end(max, max - min, Math.ceil),
  };

  // An end that is still none of the axis' even ticks, or is the zoom's, has no label: it would crowd the tick beside it.
  const even_labels = (axis, scale_of) => axis.type === 'log' ? axis : {...axis, axisLabel: {
    ...axis.axisLabel, formatter: (value) => {
      const steps = value / scale_of().getInterval();
      return Math.abs(steps - Math.round(steps)) < 1e-6 ? number(value) : '';
    },
  }};

  const below = (axis, gap = 26) => ({...axis, nameLocation: 'middle', nameGap: gap});
  const beside = (axis) =>
    ({...axis, nameLocation: 'end', nameGap: 14, nameTextStyle: {...axis.nameTextStyle, align: 'left', padding: [0, 0, 0, -46]}});

  // A silent series that only carries the lines of the marks, so that hiding a curve leaves them.
  const marks_series = (marks, ink, axis_of = (mark) => mark.on + 'Axis') => ({
    type: 'line', data: [], silent: true, tooltip: {show: false},
    markLine: {
      silent: true, symbol: 'none', animation: false,
      lineStyle: {color: ink.soft, type: [6, 4], width: 1.2},
      label: {formatter: (at) => at.name, color: ink.soft, fontSize: 11, position: 'insideEndTop'},
      data: marks.map((mark) => ({name: mark.label, [axis_of(mark)]: mark.at})),
    },
  });

  const marker = (colour) =>
    `<span style="display:inline-block;width:9px;height:9px;border-radius:50%;margin-right:5px;background:${colour}"></span>`;

  const tooltip_lines = (head, rows) => {
    const shown = rows.slice(0, 14);
    return `<b>${text(head)}</b>` +
      shown.map((row) => `<br>${row.marker}${text(row.name)}&ensp;<b>${text(row.value)}</b>`).join('') +
      (rows.length > shown.length ? `<br>and ${rows.length - shown.length} more` : '');
  };

  // ---- curves over time and in the plane

  const curve_series = (curve, colour, ink) => {
    const x = arrays[curve.x];
    const points = curve.stroke === 'points';
    const ink_of_curve = {palette: colour, neutral: ink.text, faint: ink.faint}[curve.ink];
    return {
      type: points ? 'scatter' : 'line', name: curve.name, data: interleaved(x, arrays[curve.y]), dimensions: ['x', 'y'],
      itemStyle: {color: ink_of_curve}, emphasis: {disabled: true}, z: {faint: 2, neutral: points ? 3 : 5, palette: 4}[curve.ink],
      ...(points ? {symbolSize: x.length > 500 ? 3 : 6, large: x.length > 5000, progressive: 0} : {
        showSymbol: false, step: curve.stroke === 'steps' ? 'end' : false,
        lineStyle: {
          width: curve.ink === 'palette' ? 1.7 : 1, color: ink_of_curve,
          type: {dashed: [7, 4], dotted: [2, 3]}[curve.stroke] ?? 'solid',
        },
      }),
    };
  };

  // A band is one custom series whose first visible point draws the whole area, a polygon a run without gaps. That needs all
  // its points in one go, so it is not drawn progressively.
  const band_series = (band, colour) => {
    const x = arrays[band.x], low = arrays[band.low], high = arrays[band.high];
    const data = new Float64Array(3 * x.length);
    for (let i = 0; i < x.length; ++i) data.set([x[i], low[i], high[i]], 3 * i);
    return {
      type: 'custom', name: band.name, data, dimensions: ['x', 'low', 'high'], encode: {x: 0, y: [1, 2]},
      progressive: 0, clip: true, silent: true, z: 1, itemStyle: {color: colour},
      renderItem: (params, api) => {
        if (params.dataIndexInside !== 0) return undefined;
        const polygons = [];
        let upper = [], lower = [];
        const close_run = () => {
          if (upper.length > 1)
            polygons.push({
              type: 'polygon', shape: {points: [...upper, ...lower.reverse()]}, style: {fill: colour, opacity: .2},
            });
          upper = [];
          lower = [];
        };
        for (let i = 0; i < params.dataInsideLength; ++i) {
          const at = api.value(0, i), from = api.value(1, i), to = api.value(2, i);
          if (Number.isFinite(from + to)) {
            lower.push(api.coord([at, from]));
            upper.push(api.coord([at, to]));
          } else {
            close_run();
          }
        }
        close_run();
        return {type: 'group', children: polygons};
      },
    };
  };

  // In the legend a line is a line, dashed where it is, and all else a swatch.
  const legend_entry = ({name, type}) => type === 'line' ? {name, itemStyle: {opacity: 0}} : {name, icon: 'roundRect'};

  const curves_option = (spec, ink, last_of_group, is_shown, scale_of) => {
    const over_time = spec.kind === 'line';
    const named = [...spec.curves.filter((curve) => curve.ink === 'palette'), ...spec.bands].map((item) => item.name);
    const colours = colours_of(named);
    const colour = (name) => ink.palette[colours.get(name)];
    const series = [
      ...spec.bands.map((band) => band_series(band, colour(band.name))),
      ...spec.curves.map((curve) => {
        const drawn = curve_series(curve, colour(curve.name), ink);
        return over_time && drawn.type === 'line' ? {...drawn, sampling: 'lttb'} : drawn;
      }),
    ];
    const entries = [...new Map(series.map((one) => [one.name, legend_entry(one)])).values()];
    if (spec.marks.length) series.push(marks_series(spec.marks, ink));
    const longest = Math.max(0, ...spec.curves.map((curve) => arrays[curve.x].length));
    const slider = over_time && last_of_group && longest > 100;
    const base = frame(ink);
    const top = entries.length > 1 ? 60 : 40;

    // Over time each curve is asked for its own sample at the cursor, because the thinned curves have no points in common.
    const items = [...spec.bands, ...spec.curves].map((item, i) => ({
      name: item.name, marker: marker(series[i].itemStyle.color), x: arrays[item.x],
      values: 'y' in item ? [arrays[item.y]] : [arrays[item.low], arrays[item.high]],
    }));
    const at_cursor = ([{axisValue}]) => items
      .filter(({name, x}) => is_shown(name) && axisValue >= x[0] && axisValue <= x[x.length - 1])
      .map(({name, marker, x, values}) => ({name, marker, values: values.map((y) => y[nearest(x, axisValue)])}));
    const at_points = (params) => params.filter((at) => at.seriesName)
      .map((at) => ({name: at.seriesName, marker: at.marker, values: Array.from(at.value).slice(1)}));
    const tip = (params) => {
      const rows = (over_time ? at_cursor : at_points)(params)
        .filter(({values}) => values.every(Number.isFinite))
        .map(({name, marker, values}) => (
          {name, marker, value: [...values.slice(0, -1).map(number), with_unit(values.at(-1), spec.y)].join(' to ')}));
      return rows.length ? tooltip_lines(`${spec.x.quantity} ${with_unit(params[0].axisValue, spec.x)}`, rows) : '';
    };

    const zoomed = {xAxisIndex: 0, filterMode: over_time ? 'filter' : 'none'};
    return {
      ...base,
      legend: {...base.legend, show: entries.length > 1, data: entries},
      grid: {left: 56, right: 24, top, bottom: slider ? 78 : 46},
      tooltip: {...base.tooltip, trigger: 'axis', formatter: tip},
      xAxis: below({
        ...(spec.x.log ? {} : data_ends), ...drop_empty(even_labels(value_axis(spec.x, ink), () => scale_of('xAxis'))), splitLine: {show: false},
      }),
      yAxis: beside(even_labels(value_axis(spec.y, ink), () => scale_of('yAxis'))),
      dataZoom: [
        {type: 'inside', ...zoomed, zoomOnMouseWheel: 'ctrl', moveOnMouseMove: false, moveOnMouseWheel: false, disabled: touch},
        ...(slider ? [{
          type: 'slider', ...zoomed, height: 18, bottom: 8, brushSelect: false, showDataShadow: false,
          borderColor: ink.line, fillerColor: ink.accent + '22', handleStyle: {color: ink.card, borderColor: ink.soft},
          moveHandleStyle: {color: ink.faint}, textStyle: {color: ink.soft, fontSize: 10}, labelFormatter: number,
        }] : []),
      ],
      // Off the canvas: only its zoom by dragging is wanted, which stays switched on.
      toolbox: {left: -200, feature: {dataZoom: {yAxisIndex: over_time ? 'none' : 0, filterMode: zoomed.filterMode}}},
      series,
    };
  };

  const drop_empty = (object) => Object.fromEntries(Object.entries(object).filter(([, value]) => value !== undefined));

  // ---- bars

  const bar_label_width = () => Math.min(222, 0.32 * innerWidth);

  // Bars lie where their categories would not find room side by side.
  const lies = (spec) => spec.categories.length > 12 || spec.categories.some((category) => category.length > 12);

  const bar_option = (spec, ink) => {
    const lying = lies(spec);
    const label_width = bar_label_width();
    const colours = colours_of(spec.series.map((one) => one.name));
    const category = {
      ...axis_form(ink), type: 'category', data: spec.categories, inverse: lying, axisTick: {show: false},
      splitLine: {show: false},
    };
    category.axisLabel = {...category.axisLabel, hideOverlap: false, interval: 0, width: lying ? label_width : undefined, overflow: 'break', lineHeight: 15};
    const value = {...value_axis(spec.value, ink), scale: false};
    if (spec.value.log) {
      value.startValue = spec.value.min;  // of the bars, which else begin at 1: that of a single count has no height
      value.axisLabel.formatter = (at) => Number.isInteger(Math.log10(at)) ? number(at) : '';
    }
    const labelled = spec.series.length * spec.categories.length <= 24;
    const top = spec.series.length > 1 ? 60 : 40;
    const series = spec.series.map((one) => ({
      type: 'bar', name: one.name, data: Array.from(arrays[one.values], (v) => Number.isFinite(v) ? v : null),
      itemStyle: {color: ink.palette[colours.get(one.name)], borderRadius: 2}, barMaxWidth: 34, emphasis: {disabled: true},
      label: {show: labelled, position: lying ? 'right' : 'top', color: ink.soft, fontSize: 11, formatter: (at) => number(at.value)},
    }));
    if (spec.marks.length) series.push(marks_series(spec.marks, ink, () => lying ? 'xAxis' : 'yAxis'));
    const base = frame(ink);
    return {
      ...base,
      legend: {...base.legend, show: spec.series.length > 1},
      grid: lying ? {left: label_width + 16, right: 52, top: top - 20, bottom: 46} : {left: 56, right: 24, top, bottom: 28},
      tooltip: {
        ...base.tooltip, trigger: 'axis', axisPointer: {type: 'shadow'},
        formatter: (params) => tooltip_lines(params[0].name, params.map(
          (at) => ({marker: at.marker, name: at.seriesName, value: with_unit(at.value, spec.value)}))),
      },
      xAxis: lying ? below(value, 28) : category,
      yAxis: lying ? category : beside(value),
      series,
    };
  };

  // ---- histogram

  const histogram_option = (spec, ink) => {
    const edges = arrays[spec.edges], counts = arrays[spec.counts];
    const [colour] = ink.palette;
    const bins = Array.from(counts, (count, i) => [edges[i], edges[i + 1], count]);
    const base = frame(ink);
    const series = [{
      type: 'custom', data: bins, encode: {x: [0, 1], y: 2}, itemStyle: {color: colour},
      renderItem: (params, api) => {
        const [left, top] = api.coord([api.value(0), api.value(2)]);
        const [right, bottom] = api.coord([api.value(1), 0]);
        return {
          type: 'rect', style: {fill: colour},
          shape: {x: left, y: top, width: Math.max(1, right - left - 1), height: bottom - top},
        };
      },
    }];
    if (spec.marks.length) series.push(marks_series(spec.marks, ink));
    return {
      ...base,
      grid: {left: 56, right: 24, top: 40, bottom: 46},
      tooltip: {
        ...base.tooltip, trigger: 'item',
        formatter: ({value: [low, high, count]}) =>
          `${text(number(low))} to ${text(with_unit(high, spec.value))}<br><b>${count}</b> samples`,
      },
      xAxis: below({...value_axis(spec.value, ink), splitLine: {show: false}}),
      yAxis: beside({...value_axis({quantity: 'Samples', unit: ''}, ink), scale: false, minInterval: 1}),
      series,
    };
  };

  // ---- heat map

  const heat_option = (spec, ink) => {
    const cells = arrays[spec.cells], width = spec.columns.length;
    const data = Array.from(cells, (value, i) => [i % width, Math.floor(i / width), value])
      .filter(([, , value]) => Number.isFinite(value));
    const values = data.map(([, , value]) => value);
    const least = spec.value.min ?? Math.min(...values), greatest = spec.value.max ?? Math.max(...values);
    const category = (names, quantity) => ({
      ...axis_form(ink), type: 'category', data: names, name: quantity, splitLine: {show: false}, axisTick: {show: false},
    });
    const base = frame(ink);
    return {
      ...base,
      grid: {left: 14, right: 96, top: 40, bottom: 30, containLabel: true},
      tooltip: {
        ...base.tooltip, trigger: 'item',
        formatter: ({value: [column, row, value]}) =>
          `${text(spec.row_quantity)} ${text(spec.rows[row])}<br>${text(spec.column_quantity)} ${text(spec.columns[column])}` +
          `<br><b>${text(with_unit(value, spec.value))}</b>`,
      },
      xAxis: below(category(spec.columns, spec.column_quantity), 28),
      yAxis: {
        ...category(spec.rows, spec.row_quantity), inverse: true, nameLocation: 'start', nameGap: 16,
        nameTextStyle: {color: ink.soft, fontSize: 12, align: 'left', padding: [0, 0, 0, -38]},
      },
      title: {text: axis_name(spec.value), right: 4, top: 10, textStyle: {color: ink.soft, fontSize: 12, fontWeight: 'normal'}},
      visualMap: {
        type: 'continuous', min: least, max: greatest, right: 24, top: 36, itemHeight: 120,
        text: [number(greatest), number(least)], textStyle: {color: ink.soft, fontSize: 11}, formatter: number,
        inRange: {color: ['#00224e', '#2a3f6d', '#575d6d', '#7c7b78', '#a59c74', '#d2c060', '#fee838']}, // cividis
      },
      series: [{
        type: 'heatmap', data, itemStyle: {borderColor: ink.card, borderWidth: 1},
        label: {show: data.length <= 150, fontSize: 11, formatter: ({value}) => number(Number(value[2].toPrecision(2)))},
      }],
    };
  };

  // ---- drawing

  const last_with_group = new Map(page.charts.map((spec, index) => [spec.group, index]));
  const option_of = (spec, index, ink) => {
    const is_shown = (name) => charts[index]?.selected[name] !== false;
    const scale_of = (axis) => charts[index].chart.getModel().getComponent(axis).axis.scale;
    switch (spec.kind) {
      case 'line': return curves_option(spec, ink, !spec.group || last_with_group.get(spec.group) === index, is_shown, scale_of);
      case 'xy': return curves_option(spec, ink, false, is_shown, scale_of);
      case 'bar': return bar_option(spec, ink);
      case 'histogram': return histogram_option(spec, ink);
      case 'heat': return heat_option(spec, ink);
      default: throw new Error(`unknown kind of chart: ${spec.kind}`);
    }
  };

  const charts = [];
  const report_problem = (message) => { root.dataset.problem = message; };
  addEventListener('error', (event) => report_problem(event.message));

  const paint = (entry, ink) => {
    entry.chart.setOption(option_of(entry.spec, entry.index, ink), {notMerge: true});
    if (!touch && (entry.spec.kind === 'line' || entry.spec.kind === 'xy'))
      entry.chart.dispatchAction({type: 'takeGlobalCursor', key: 'dataZoomSelect', dataZoomSelectActive: true});
  };

  const create = (plot, index, ink) => {
    const spec = page.charts[index];
    if (spec.kind === 'bar' && lies(spec)) {
      const letters = bar_label_width() / 6.2;  // that fit into a line of a label
      const lines = Math.max(1, ...spec.categories.map((category) => Math.ceil(category.length / letters)));
      const each = Math.max(20 * Math.max(1, spec.series.length), 15 * lines + 6);
      const height = 110 + each * spec.categories.length;
      if (height > 340) plot.style.height = height + 'px';
    }
    if (spec.kind === 'heat') plot.style.height = Math.max(260, 120 + 30 * spec.rows.length) + 'px';
    const chart = echarts.init(plot, null, {renderer: vector ? 'svg' : 'canvas'});
    const entry = charts[index] = {chart, spec, index, selected: {}};
    chart.on('legendselectchanged', ({selected}) => { entry.selected = selected; });
    paint(entry, ink);
    chart.getZr().on('dblclick', () => chart.dispatchAction({type: 'dataZoom', start: 0, end: 100}));
    if (spec.group) chart.group = spec.group;
    new ResizeObserver(() => chart.resize()).observe(plot);
  };

  const paint_all = () => {
    const ink = inks();
    charts.forEach((entry) => {
      entry.selected = {};
      paint(entry, ink);
    });
  };

  // ---- light and dark

  const choices = ['auto', 'light', 'dark'];
  let choice = 'auto';
  const button = document.getElementById('theme');
  const set_theme = (theme) => { root.dataset.theme = theme; };
  const apply_choice = () => {
    set_theme(choice === 'auto' ? (darkSystem.matches ? 'dark' : 'light') : choice);
    button.textContent = {auto: 'Auto', light: 'Light', dark: 'Dark'}[choice];
    button.title = `Colours: ${choice}. Press to change.`;
    button.setAttribute('aria-label', button.title);
    paint_all();
  };
  button.hidden = false;
  button.addEventListener('click', () => {
    choice = choices[(choices.indexOf(choice) + 1) % choices.length];
    apply_choice();
  });
  darkSystem.addEventListener('change', apply_choice);
  apply_choice();

  addEventListener('beforeprint', () => {
    set_theme('light');
    paint_all();
    charts.forEach(({chart}) => chart.resize({width: printed_width}));
  });
  addEventListener('afterprint', () => {
    apply_choice();
    charts.forEach(({chart}) => chart.resize({width: 'auto'}));
  });

  const ink = inks();
  document.querySelectorAll('.plot').forEach((plot, index) => {
    try {
      create(plot, index, ink);
    } catch (error) {
      plot.textContent = `This chart could not be drawn: ${error.message}`;
      report_problem(error.message);
      console.error(error);
    }
  });
  for (const group of new Set(page.charts.map((spec) => spec.group).filter(Boolean))) echarts.connect(group);
  root.dataset.charts = String(Object.keys(charts).length);
})();
