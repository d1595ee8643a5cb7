// SPDX-License-Identifier: MIT
// Draws the charts of a report from its data, and shows the picture of a chosen row beside the reference.
// All text from the data becomes text nodes. Charts are drawn for their present width, so that text has
// one size at every width.
'use strict';
(() => {
    const data = JSON.parse(document.getElementById('data').textContent);
    const COLOURS = 6;

    const isObject = (value) => value !== null && typeof value === 'object' && !Array.isArray(value);
    const list = (value) => (Array.isArray(value) ? value : []);
    const rows = list(data && data.rows).filter(isObject);
    const isPositive = (value) => Number.isFinite(value) && value > 0;

    const html = (tag, className, text) => {
        const element = document.createElement(tag);
        if (className) element.className = className;
        if (text !== undefined) element.textContent = text;
        return element;
    };
    const svg = (tag, attributes, text) => {
        const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
        for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
        if (text !== undefined) element.textContent = text;
        return element;
    };

    // 0.00123, 12.3, 12 345.
    const format = (value) => {
        const size = Math.abs(value);
        if (size >= 1e7 || (size > 0 && size < 1e-4))
            return value.toExponential(0).replace('e', ' × 10^').replace('+', '');
        return size >= 1000
            ? Math.round(value).toLocaleString('en').replaceAll(',', '\u202f')
            : String(Number(value.toPrecision(3)));
    };

    const SAMPLES = ['samples_per_pixel', 'lens_samples', 'light_samples', 'blur_samples'];
    const nameOf = (settings, skip) => {
        const entries = Object.entries(isObject(settings) ? settings : {});
        const target = isObject(settings) && settings.target_error > 0;
        return entries
            .filter(
                ([key, value]) =>
                    key !== skip &&
                    !(key === 'target_error' && !(value > 0)) &&
                    !(target && SAMPLES.includes(key)),
            )
            .map(([key, value]) => `${key} ${typeof value === 'string' ? value : JSON.stringify(value)}`)
            .join(', ');
    };
    const rowName = (row) => nameOf(row.settings) || "the scene's settings";

    // The ticks of an axis over [low, high]: at most `most`.
    const linearTicks = (low, high, most) => {
        const raw = (high - low) / most,
            power = 10 ** Math.floor(Math.log10(raw));
        const step = [1, 2, 5, 10].map((digit) => digit * power).find((size) => size >= raw * 0.999);
        const ticks = [];
        for (let k = Math.ceil(low / step); k * step <= high * (1 + 1e-9); k++)
            ticks.push(Number((k * step).toPrecision(12)));
        return ticks;
    };
    const logarithmicTicks = (low, high, most) => {
        for (const digits of [[1, 2, 5], [1], [1]]) {
            const ticks = [];
            const stride = digits.length > 1 ? 1 : Math.max(1, Math.ceil(Math.log10(high / low) / most));
            for (let k = Math.floor(Math.log10(low)); 10 ** k <= high; k++)
                for (const digit of digits)
                    if (k % stride === 0 && digit * 10 ** k >= low * 0.999 && digit * 10 ** k <= high * 1.001)
                        ticks.push(Number((digit * 10 ** k).toPrecision(12)));
            if (ticks.length <= most && ticks.length > 1) return ticks;
        }
        return [low, high];
    };

    // An axis {label, log, values, ticks, from} that maps values to [first, end].
    const scale = (axis, first, end, most) => {
        const values = axis.values.filter((value) => Number.isFinite(value) && (!axis.log || value > 0));
        let low = Math.min(...values, ...(axis.from === undefined ? [] : [axis.from]));
        let high = Math.max(...values);
        if (axis.log) {
            const least = Math.sqrt(3 / Math.min(high / low, 3)) * 1.2;
            low /= least;
            high *= least;
        } else {
            const margin = (high - low || Math.abs(high) || 1) * 0.08;
            low = axis.from === undefined || low < axis.from ? low - margin : low;
            high += margin;
        }
        const at = axis.log ? Math.log : (value) => value;
        const place = (value) =>
            first +
            ((at(Math.min(Math.max(value, low), high)) - at(low)) / (at(high) - at(low))) * (end - first);
        const ticks =
            axis.ticks ||
            (axis.log ? logarithmicTicks(low, high, most) : linearTicks(low, high, most)).map((value) => [
                value,
                format(value),
            ]);
        return { place, ticks, low, high };
    };

    // Adds a chart in a figure with its caption. It is drawn again when its width changes.
    const addChart = (title, caption, draw) => {
        const figure = html('figure', 'chart'),
            holder = html('div');
        let drawn = 0;
        figure.append(html('h2', '', title), holder, html('figcaption', '', caption));
        document.getElementById('charts').append(figure);
        const redraw = () => {
            const width = Math.round(Math.min(Math.max(holder.clientWidth, 280), 720));
            if (width === drawn) return;
            drawn = width;
            const root = svg('svg', { role: 'img', 'aria-label': title });
            root.append(svg('title', {}, title));
            const height = draw(root, width);
            root.setAttribute('viewBox', `0 0 ${width} ${height}`);
            holder.replaceChildren(root);
        };
        redraw();
        new ResizeObserver(() => requestAnimationFrame(redraw)).observe(holder);
        return figure;
    };

    const drawAxes = (root, x, y, box, axes) => {
        const { left, right, top, bottom } = box;
        for (const [value, text] of y.ticks) {
            const place = y.place(value);
            root.append(
                svg('path', { class: 'grid', d: `M${left} ${place}H${right}` }),
                svg('text', { class: 'tick', x: left - 6, y: place + 4, 'text-anchor': 'end' }, text),
            );
        }
        for (const [value, text] of x.ticks) {
            const place = x.place(value);
            const anchor = place > right - 20 ? 'end' : 'middle';
            root.append(
                svg('path', { class: 'grid', d: `M${place} ${top}V${bottom + 4}` }),
                svg('text', { class: 'tick', x: place, y: bottom + 18, 'text-anchor': anchor }, text),
            );
        }
        root.append(
            svg('text', { class: 'label', x: 2, y: 12 }, axes.y.label),
            svg('text', { class: 'label', x: right, y: bottom + 36, 'text-anchor': 'end' }, axes.x.label),
        );
    };

    const overlaps = (a, b) =>
        a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;

    // Writes a label beside a point where it overlaps no other label and no dot. Without such a place,
    // there is no label.
    const drawLabel = (root, text, x, y, box, taken) => {
        const width = text.length * 7,
            height = 14;
        for (const [left, top] of [
            [x + 8, y - 14],
            [x + 8, y + 2],
            [x - 8 - width, y - 14],
            [x - 8 - width, y + 2],
        ]) {
            const place = { x: left, y: top, width, height };
            if (
                left < box.left ||
                left + width > box.right + 4 ||
                top < 14 ||
                top + height > box.bottom ||
                taken.some((other) => overlaps(other, place))
            )
                continue;
            taken.push(place);
            root.append(svg('text', { x: left, y: top + 11, class: 'tick' }, text));
            return;
        }
    };

    const drawPoint = (root, x, y, point) => {
        const [px, py] = [x.place(point.x), y.place(point.y)];
        if (point.xs)
            root.append(
                svg('path', {
                    class: 'whisker',
                    d: `M${x.place(point.xs[0])} ${py}H${x.place(point.xs[1])}`,
                }),
            );
        if (point.ys)
            root.append(
                svg('path', {
                    class: 'whisker',
                    d: `M${px} ${y.place(point.ys[0])}V${y.place(point.ys[1])}`,
                }),
            );
        const dot = point.below
            ? svg('path', { class: 'dot', d: `M${px - 5} ${py - 4}h10l-5 9z` })
            : svg('circle', { class: 'dot', cx: px, cy: py, r: 4 });
        dot.append(svg('title', {}, point.title));
        root.append(dot);
        if (point.ring) root.append(svg('circle', { class: 'ring', cx: px, cy: py, r: 8 }));
    };

    // Adds a chart of points {x, y, xs, ys, title, label, colour, below, ring}, lines {points, colour, ideal}
    // and marks {x, text}.
    const addPlot = ({ title, caption, axes, points, lines = [], marks = [], legend = [] }) => {
        const figure = addChart(title, caption, (root, width) => {
            const height = Math.round(Math.min(Math.max(width * 0.62, 250), 400));
            const box = { left: 62, right: width - 10, top: 24, bottom: height - 44 };
            const x = scale(axes.x, box.left, box.right, Math.floor(width / 70)),
                y = scale(axes.y, box.bottom, box.top, 6);
            drawAxes(root, x, y, box, axes);
            for (const line of lines)
                root.append(
                    svg('path', {
                        class: `${line.ideal ? 'ideal' : 'line'} c${line.colour % COLOURS}`,
                        fill: 'none',
                        d:
                            'M' +
                            line.points.map((point) => `${x.place(point[0])} ${y.place(point[1])}`).join('L'),
                    }),
                );
            for (const mark of marks) {
                const place = x.place(mark.x);
                root.append(
                    svg('path', { class: 'ideal', d: `M${place} ${box.top}V${box.bottom}` }),
                    svg(
                        'text',
                        { x: Math.min(place, width - 30), y: box.top - 4, 'text-anchor': 'middle' },
                        mark.text,
                    ),
                );
            }
            const taken = points.map((point) => ({
                x: x.place(point.x) - 5,
                y: y.place(point.y) - 5,
                width: 10,
                height: 10,
            }));
            for (const point of points) {
                const group = svg('g', { class: point.colour < 0 ? 'grey' : `c${point.colour % COLOURS}` });
                drawPoint(group, x, y, point);
                if (point.label)
                    drawLabel(group, point.label, x.place(point.x), y.place(point.y), box, taken);
                root.append(group);
            }
            return height;
        });
        if (legend.length > 0) {
            const keys = html('ul', 'legend');
            legend.forEach((text, i) => {
                const item = html('li', `c${i % COLOURS}`);
                item.append(html('span', 'key'), text);
                keys.append(item);
            });
            figure.insertBefore(keys, figure.lastChild);
        }
    };

    // Adds a chart of bars {name, value, low, high, text, base, open}. Each bar has its name above it.
    const addBars = ({ title, caption, label, bars, log }) => {
        if (bars.length === 0) return;
        addChart(title, caption, (root, width) => {
            const LINE = 40,
                box = { left: 4, right: width - 12, top: 20, bottom: 20 + LINE * bars.length };
            const values = bars.flatMap((bar) => [bar.value, bar.low, bar.high]).filter(Number.isFinite);
            const axis = { label, log, values, from: log ? undefined : 0 };
            const x = scale(axis, box.left, box.right, Math.floor(width / 70)),
                begin = x.place(log ? x.low : 0);
            drawAxes(root, x, { ticks: [] }, box, { x: axis, y: { label: '' } });
            bars.forEach((bar, i) => {
                const y = box.top + LINE * i,
                    end = x.place(bar.value);
                const group = svg('g', {});
                group.append(
                    svg('rect', {
                        class: bar.open ? 'open' : bar.base ? 'bar base' : 'bar',
                        x: Math.min(begin, end),
                        y: y + 14,
                        width: Math.max(Math.abs(end - begin), 1),
                        height: 16,
                    }),
                    svg('text', { x: box.left, y: y + 10 }, `${bar.name}: ${bar.text}`),
                );
                if (Number.isFinite(bar.low) && Number.isFinite(bar.high))
                    group.append(
                        svg('path', {
                            class: 'whisker',
                            fill: 'none',
                            d: `M${x.place(bar.low)} ${y + 18}v8m0 -4H${x.place(bar.high)}m0 -4v8`,
                        }),
                    );
                root.append(group);
            });
            return box.bottom + 42;
        });
    };

    // The interval of the median of sorted values, some of which are spoiled (src/study/verdict.h).
    const intervalOf = (values, spoiled) => {
        let term = 2 ** -values.length,
            below = 0,
            k = 0;
        while (k < values.length && 2 * (below + term) <= 0.05) {
            below += term;
            term *= (values.length - k) / (k + 1);
            k++;
        }
        k -= spoiled;
        return values.length >= 10 && k > 0
            ? [values[k - 1], values[values.length - k]]
            : [values[0], values[values.length - 1]];
    };

    // The speed-up of a row over another, from pairs of runs of one repeat.
    const speedupOf = (base, row) => {
        const pairs = list(row.runs_ms).map((ms, i) => list(base.runs_ms)[i] / ms),
            spoiled = new Set([...list(base.spoiled_runs), ...list(row.spoiled_runs)]);
        const values = pairs.filter(isPositive).sort((a, b) => a - b);
        if (values.length === 0) return null;
        const median = (values[(values.length - 1) >> 1] + values[values.length >> 1]) / 2;
        return { median, interval: intervalOf(values, spoiled.size) };
    };

    const drawThreads = () => {
        const groups = new Map();
        for (const row of rows) {
            if (
                !isObject(row.settings) ||
                !Number.isInteger(row.threads) ||
                row.threads < 1 ||
                row.threads > 4096
            )
                continue;
            const name = nameOf(row.settings, 'threads') || 'all rows';
            groups.set(name, [...(groups.get(name) || []), row]);
        }
        const series = [...groups]
            .filter(([, members]) => new Set(members.map((row) => row.threads)).size > 1)
            .slice(0, COLOURS);
        const points = [],
            lines = [];
        series.forEach(([name, members], colour) => {
            members.sort((a, b) => a.threads - b.threads);
            const own = [];
            for (const row of members) {
                const speedup = speedupOf(members[0], row);
                if (speedup)
                    own.push({
                        x: row.threads,
                        y: speedup.median,
                        ys: speedup.interval,
                        colour,
                        title: `${name}, ${row.threads} threads: ${format(speedup.median)} times`,
                    });
            }
            lines.push({ points: own.map((point) => [point.x, point.y]), colour });
            points.push(...own);
        });
        if (points.length < 2) return;
        const xs = points.map((point) => point.x),
            first = Math.min(...xs),
            last = Math.max(...xs),
            log = last / first > 8;
        lines.unshift({
            points: Array.from({ length: 33 }, (_, i) => first * (last / first) ** (i / 32)).map(
                (threads) => [threads, threads / first],
            ),
            colour: 0,
            ideal: true,
        });
        addPlot({
            title: 'Threads',
            points,
            lines,
            legend: series.map(([name]) => name),
            caption:
                'How many times as fast a row is as that of the fewest threads, by pairs of runs; bars: 95 % ' +
                'intervals, or least to largest below 10 pairs. Dashed: as many times as there are threads.',
            axes: {
                x: {
                    label: 'threads',
                    log,
                    values: xs,
                    from: log ? undefined : 0,
                    ticks: [...new Set(xs)].map((threads) => [threads, String(threads)]),
                },
                y: {
                    label: 'speed-up, times',
                    log,
                    values: [1, ...points.flatMap((point) => [point.y, ...point.ys]), last / first],
                    from: log ? undefined : 0,
                },
            },
        });
    };

    const drawBenchmark = () => {
        const timed = rows.filter((row) => isPositive(row.median_ms));
        const medians = timed.map((row) => row.median_ms),
            log = Math.max(...medians) / Math.min(...medians) > 30;
        addBars({
            title: 'Times',
            label: log ? 'milliseconds (logarithmic)' : 'milliseconds',
            log,
            caption:
                'Bar: median. Whisker: least to largest. Grey: the row that speed-ups refer to.' +
                (log ? ' The axis is logarithmic.' : ''),
            bars: timed.map((row, i) => ({
                name: rowName(row),
                value: row.median_ms,
                low: row.min_ms,
                high: row.max_ms,
                base: i === data.baseline,
                text: `${format(row.median_ms)} ms`,
            })),
        });
        drawThreads();
    };

    const METRICS = { rmse: 'RMSE', flip: 'FLIP' };

    const drawErrors = (metric) => {
        const single = rows.length > 0 && Object.keys(rows[0].settings || {}).length === 1;
        const points = [];
        rows.forEach((row, i) => {
            const below = row.resolved === false && metric === 'rmse',
                y = below ? row.rmse_below : row[metric];
            if (!isPositive(row.median_ms) || !isPositive(y)) return;
            const spread = list(row.spread && row.spread[metric]);
            points.push({
                x: row.median_ms,
                y,
                below,
                row,
                xs: [row.min_ms, row.max_ms],
                ys: spread.length === 2 && spread.every(isPositive) ? spread : null,
                colour: row.pareto ? 0 : -1,
                label: single ? String(Object.values(row.settings)[0]) : String(i),
                ring: data.recommended && data.recommended.row === i,
                title:
                    `row ${i}, ${rowName(row)}: ${format(row.median_ms)} ms, ` +
                    `${METRICS[metric]} ${below ? 'below ' : ''}${format(y)}`,
            });
        });
        if (points.length === 0) return;
        const front = points.filter((point) => point.row.pareto).sort((a, b) => a.x - b.x);
        addPlot({
            title: `${METRICS[metric]} against time`,
            points,
            lines: front.length > 1 ? [{ points: front.map((point) => [point.x, point.y]), colour: 0 }] : [],
            caption:
                `Each point is a row, labelled by ${single ? 'its setting' : 'its number in the table'}; bars: ` +
                'least to largest time, 5 to 95 % of the errors. The line is the Pareto front: rows that no ' +
                'other row beats in both. Grey rows are beaten. A triangle is a row whose error lies somewhere ' +
                'below it. Ringed: the cheapest row that meets the target. Both axes are logarithmic.',
            axes: {
                x: {
                    label: 'time, milliseconds',
                    log: true,
                    values: points.flatMap((point) => [point.x, ...point.xs]),
                },
                y: {
                    label: METRICS[metric],
                    log: true,
                    values: points.flatMap((point) => [point.y, ...(point.ys || [])]),
                },
            },
        });
    };

    const drawConvergence = () => {
        const points = [],
            lines = [],
            legend = [];
        list(data.convergence)
            .filter(isObject)
            .forEach((series, colour) => {
                const own = list(series.points).filter(
                    (point) => isPositive(point.samples) && isPositive(point.rmse),
                );
                const others = nameOf(series.with);
                legend.push(
                    `${series.setting}${others ? ` with ${others}` : ''}: slope ${format(series.slope)}`,
                );
                for (const point of own)
                    points.push({
                        x: point.samples,
                        y: point.rmse,
                        colour,
                        title: `row ${point.row}: ${point.samples} samples, RMSE ${format(point.rmse)}`,
                    });
                const ends = own.map((point) => point.samples);
                if (own.length > 1 && isPositive(series.rmse_at_1))
                    lines.push({
                        colour,
                        points: [Math.min(...ends), Math.max(...ends)].map((samples) => [
                            samples,
                            series.rmse_at_1 * samples ** series.slope,
                        ]),
                    });
            });
        if (points.length < 2) return;
        addPlot({
            title: 'How fast errors fall',
            points,
            lines,
            legend,
            caption:
                'RMSE against the number of samples, and the line that fits it best, with its slope. Both axes are logarithmic.',
            axes: {
                x: { label: 'samples', log: true, values: points.map((point) => point.x) },
                y: { label: 'RMSE', log: true, values: points.map((point) => point.y) },
            },
        });
    };

    const drawCosts = () => {
        const costOf = (row) => (Number.isFinite(row.cost_ms) ? row.cost_ms : row.cost_below_ms);
        const known = rows
            .filter((row) => row.without && Number.isFinite(costOf(row)))
            .sort((a, b) => costOf(b) - costOf(a));
        addBars({
            title: 'Costs',
            label: 'milliseconds',
            caption:
                'What each effect costs: the whole time less the time without it. Dashed: at most so much, ' +
                'since the runs do not distinguish it.',
            bars: known.map((row) => {
                const certain = Number.isFinite(row.cost_ms);
                const text = certain
                    ? `${format(row.cost_ms)} ms, ${format(100 * row.cost_share)} %`
                    : `below ${format(row.cost_below_ms)} ms`;
                return { name: row.without, value: costOf(row), open: !certain, text };
            }),
        });
    };

    const drawEffects = () => {
        drawCosts();
        addBars({
            title: 'Times',
            label: 'milliseconds',
            caption:
                'The scene without each effect. Bar: median. Whisker: least to largest. Grey: with all effects.',
            bars: rows
                .filter((row) => isPositive(row.median_ms))
                .map((row) => ({
                    name: row.without ? `without ${row.without}` : 'all effects',
                    value: row.median_ms,
                    low: row.min_ms,
                    high: row.max_ms,
                    base: !row.without,
                    text: `${format(row.median_ms)} ms`,
                })),
        });
    };

    const drawSeries = (row) => {
        const reports = list(data.reports);
        const points = list(row.points)
            .map((point, i) => {
                const report = reports[point.report] || {};
                const date = String(report.began_at || '').slice(0, 10);
                return {
                    x: i,
                    y: point.median_ms,
                    ys: Number.isFinite(point.low_ms) ? [point.low_ms, point.high_ms] : null,
                    colour: report.host || 0,
                    date,
                    title: `${date} build ${String(report.build || '').slice(0, 7)}: ${format(point.median_ms)} ms`,
                };
            })
            .filter((point) => isPositive(point.y));
        if (points.length === 0) return;
        const each = Math.ceil(points.length / 3);
        addPlot({
            title: nameOf(row.settings) || 'all runs',
            points,
            marks: list(row.changes).map((change) => ({
                x: change.point - 0.5,
                text: `${change.ratio >= 1 ? '+' : ''}${((change.ratio - 1) * 100).toFixed(1)} %`,
            })),
            legend: list(data.hosts).map((host, i) => `host ${i}: ${host.cpu}`),
            caption:
                'Dot: the median of a report. Bar: its 95 % interval. Colour: the host. Dashed: a change among the reports of one host.',
            axes: {
                x: {
                    label: 'reports in the order of time',
                    values: [-0.5, points.length - 0.5],
                    ticks: points.filter((_, i) => i % each === 0).map((point) => [point.x, point.date]),
                },
                y: {
                    label: 'median, milliseconds',
                    values: points.flatMap((point) => [point.y, ...(point.ys || [])]),
                },
            },
        });
    };

    const CROP = 96,
        CROP_STEP = 24;

    const pixelsOf = (image) => {
        const canvas = html('canvas');
        canvas.width = image.naturalWidth;
        canvas.height = image.naturalHeight;
        const context = canvas.getContext('2d');
        context.drawImage(image, 0, 0);
        return context.getImageData(0, 0, canvas.width, canvas.height).data;
    };

    // Finds the part of a picture that differs most from the reference.
    const findCrop = (image, reference) => {
        const width = image.naturalWidth,
            height = image.naturalHeight,
            size = Math.min(CROP, width, height);
        const a = pixelsOf(image),
            b = pixelsOf(reference);
        let best = { x: 0, y: 0, size, sum: -1 };
        for (let y = 0; y + size <= height; y += CROP_STEP)
            for (let x = 0; x + size <= width; x += CROP_STEP) {
                let sum = 0;
                for (let j = y; j < y + size; j++)
                    for (let i = 4 * (j * width + x); i < 4 * (j * width + x + size); i++)
                        sum += Math.abs(a[i] - b[i]);
                if (sum > best.sum) best = { x, y, size, sum };
            }
        return best;
    };

    const enlarged = (image, crop, caption) => {
        const figure = html('figure'),
            canvas = html('canvas');
        canvas.width = canvas.height = 3 * crop.size;
        canvas.setAttribute('role', 'img');
        canvas.setAttribute('aria-label', caption);
        const context = canvas.getContext('2d');
        context.imageSmoothingEnabled = false;
        context.drawImage(image, crop.x, crop.y, crop.size, crop.size, 0, 0, canvas.width, canvas.height);
        figure.append(canvas, html('figcaption', '', caption));
        return figure;
    };

    const pairOf = (...figures) => {
        const pair = html('div', 'pair');
        pair.append(...figures);
        return pair;
    };

    const whenLoaded = (image) =>
        image.complete ? Promise.resolve() : new Promise((done) => image.addEventListener('load', done));

    const showPictures = async () => {
        const figures = [...document.querySelectorAll('.pictures .picture')],
            reference = document.querySelector('.pictures .reference');
        const viewer = document.getElementById('viewer');
        if (figures.length === 0 || !reference) return;
        const images = [...document.querySelectorAll('.pictures img')];
        await Promise.all(images.map(whenLoaded));
        const hasMaps = document.querySelector('.pictures .map') !== null;
        const original = reference.querySelector('img');
        const fixed = hasMaps ? findCrop(figures[0].querySelector('img'), original) : null;
        const label = html('label', '', 'Show '),
            select = html('select'),
            shown = html('div');
        select.id = 'choose';
        for (const figure of figures) {
            const option = html('option', '', figure.querySelector('figcaption').textContent);
            option.value = figure.dataset.row;
            select.append(option);
        }
        const show = () => {
            const row = select.value,
                figure = figures.find((one) => one.dataset.row === row),
                image = figure.querySelector('img');
            const map = document.querySelector(`.pictures .map[data-row="${Number(row)}"]`);
            const crop = fixed || findCrop(image, original);
            shown.replaceChildren(
                pairOf(figure.cloneNode(true), reference.cloneNode(true)),
                pairOf(
                    enlarged(image, crop, 'Enlarged, where the pictures differ most'),
                    enlarged(original, crop, 'The same part of the reference'),
                ),
            );
            if (map) shown.append(pairOf(map.cloneNode(true)));
        };
        select.value =
            data.recommended && figures.some((figure) => figure.dataset.row === String(data.recommended.row))
                ? String(data.recommended.row)
                : figures[figures.length - 1].dataset.row;
        select.addEventListener('change', show);
        label.append(select);
        viewer.append(label, shown, html('h2', '', 'All pictures'));
        show();
    };

    if (!isObject(data)) return;
    if (data.kind === 'accuracy') {
        drawErrors('rmse');
        drawErrors('flip');
        drawConvergence();
    } else if (data.kind === 'effects') drawEffects();
    else if (data.kind === 'history') rows.forEach(drawSeries);
    else drawBenchmark();
    showPictures();
})();
