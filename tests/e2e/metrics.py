# SPDX-License-Identifier: MIT
"""Checks Prometheus' text format 0.0.4 from standard input, where promtool is missing: metrics.py
prints one line for each fault. Names, help and type before the first sample, one block for each
metric, units and endings of names, no series twice, histograms that add up."""
import re
import sys

SAMPLE = re.compile(r'([a-zA-Z_:][a-zA-Z0-9_:]*)(?:\{([^}]*)\})? (\S+)$')
LABEL = re.compile(r'([a-zA-Z_][a-zA-Z0-9_]*)="((?:[^"\\\n]|\\["\\n])*)"(?:,|$)')
WRONG_UNITS = ('_ms', '_us', '_ns', '_milliseconds', '_minutes', '_kb', '_mib', '_percent')


def family(name, types):
    for ending in ('_bucket', '_sum', '_count'):
        if name.endswith(ending) and types.get(name[:-len(ending)]) == 'histogram':
            return name[:-len(ending)]
    return name


def check_histogram(name, series, fault):
    buckets = [(float(dict(labels)['le']), value) for (n, labels), value in series.items()
               if n == name + '_bucket']
    values = [value for _, value in sorted(buckets)]
    if not buckets or sorted(buckets)[-1][0] != float('inf') or values != sorted(values):
        fault(name + ': buckets do not add up')
    elif values[-1] != series.get((name + '_count', ())):
        fault(name + ': the last bucket is not the count')
    if (name + '_sum', ()) not in series:
        fault(name + ': no sum')


def check(text, fault):
    types, helps, series, done, last = {}, {}, {}, set(), None
    if not text.endswith('\n'):
        fault('no newline at the end')
    for line in text.splitlines():
        words = line.split(' ', 3)
        if line.startswith('# HELP ') and len(words) == 4:
            helps[words[2]] = words[3]
            continue
        if line.startswith('# TYPE ') and len(words) == 4:
            types[words[2]] = words[3]
            continue
        match = SAMPLE.match(line)
        if not match:
            fault('not a sample: ' + line)
            continue
        name, labels, value = match.groups()
        pairs = tuple(LABEL.findall(labels or ''))
        if labels and ','.join('%s="%s"' % pair for pair in pairs) != labels.rstrip(','):
            fault('labels: ' + line)
        of = family(name, types)
        if of not in types or of not in helps:
            fault('no HELP or TYPE: ' + line)
        if of != last and of in done:
            fault('two blocks of ' + of)
        done.add(of)
        last = of
        if (name, pairs) in series:
            fault('twice: ' + line)
        series[name, pairs] = float(value)
    for name, kind in types.items():
        if kind not in ('counter', 'gauge', 'histogram'):
            fault('type of ' + name)
        if (kind == 'counter') != name.endswith('_total'):
            fault(name + ': counters, and no others, end in _total')
        if name.endswith(WRONG_UNITS) or any(unit + '_total' in name for unit in WRONG_UNITS):
            fault(name + ': not a base unit')
        if name not in done:
            fault(name + ': no sample')
        if kind == 'histogram':
            check_histogram(name, series, fault)


if __name__ == '__main__':
    check(sys.stdin.read(), print)
