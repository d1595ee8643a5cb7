# SPDX-License-Identifier: MIT
"""Whether a job's time left is what is left: eta.py DAEMON SCENES REPEATS

Runs each job of SCENES (a line each: name, then the body) alone on a daemon, reads it 20 times a second, and
compares eta_seconds with the time that was left, from 20 % to 95 % of the job's time. Prints a table: the share
of readings of which (eta + 0.3 s) / (left + 0.3 s) is within a factor 1.5, the 90th percentile of that factor,
the same by the processor time of the worker (what others take of the machine is no work of the job), and the
longest time in which eta_seconds and fraction did not change. A run of which others used more than a tenth of
the processors is spoiled: it is repeated, and after REPEATS tries its row counts by the better of the two clocks.
Fails if a row has less than 90 % of its readings within, or did not change for more than a second.
"""
import json, os, subprocess, sys, tempfile, time, urllib.error, urllib.request

NEAR, MARGIN_S, WANTED, PAUSE_S, SPOILED = 1.5, 0.3, 0.9, 0.05, 0.9
STILL_S = 1 + 5 * PAUSE_S  # a reading may be late
TICKS = os.sysconf("SC_CLK_TCK")


class Daemon:
    def __init__(self, program, store):
        self.process = subprocess.Popen(
            [program, "--listen", "127.0.0.1:0", "--store", store],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.url = self.process.stdout.readline().split()[-1]
        for _ in range(100):
            try:
                self.call("/readyz")
                break
            except urllib.error.HTTPError:
                time.sleep(0.1)

    def worker_s(self):
        """Processor time of the worker."""
        children = open(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read().split()
        for child in children:
            if open(f"/proc/{child}/comm").read().startswith("penumbrad-work"):
                fields = open(f"/proc/{child}/stat").read().rpartition(")")[2].split()
                return (int(fields[11]) + int(fields[12])) / TICKS
        return 0

    def call(self, path, body=None):
        request = urllib.request.Request(self.url + path, body and body.encode(),
                                         {"Content-Type": "application/json"} if body else {})
        return json.load(urllib.request.urlopen(request))


def read_job(daemon, body):
    """(seconds, processor seconds, progress) of each reading until the job ends."""
    path = daemon.call("/v1/jobs", body)["links"]["self"]
    readings = []
    while True:
        job = daemon.call(path)
        readings.append((time.monotonic(), daemon.worker_s(), job["progress"]))
        if job["state"] not in ("queued", "running"):
            assert job["state"] == "succeeded", job
            return readings
        time.sleep(PAUSE_S)


def factors(readings, clock):
    """How far each reading is off, by the clock (0) or the worker's processor time (1)."""
    begin, end = readings[0][clock], readings[-1][clock]
    out = []
    for reading in readings:
        passed, eta = reading[clock] - begin, reading[2]["eta_seconds"]
        if not 0.2 <= passed / (end - begin) <= 0.95 or not reading[2]["fraction"] < 1:
            continue
        if eta is None:
            out.append(float("inf"))
            continue
        rate = passed / (reading[0] - readings[0][0])  # of processor time, a second
        scale = (readings[-1][1] - readings[0][1]) / (readings[-1][0] - readings[0][0]) if clock else 1
        ratio = (eta * rate / scale + MARGIN_S) / ((end - reading[clock]) / scale + MARGIN_S)
        out.append(max(ratio, 1 / ratio))
    return sorted(out)


def longest_pause(readings):
    last, since, longest = None, readings[0][0], 0
    for at, _, progress in readings:
        now = (progress["eta_seconds"], progress["fraction"])
        if last is not None and now != last:
            longest, since = max(longest, at - since), at
        elif last is None:
            since = at
        last = now
    return longest


def judge(daemon, body, repeats):
    for _ in range(repeats):
        readings = read_job(daemon, body)
        seconds = readings[-1][0] - readings[0][0]
        busy = (readings[-1][1] - readings[0][1]) / seconds / len(os.sched_getaffinity(0))
        row = {"seconds": seconds, "busy": busy, "pause": longest_pause(readings)}
        for clock, name in enumerate(("wall", "work")):
            off = factors(readings, clock)
            row[name] = (sum(f <= NEAR for f in off) / len(off), off[int(0.9 * (len(off) - 1))])
        if busy >= SPOILED:
            break
    row["spoiled"] = busy < SPOILED
    return row


def table(daemon, scenes, repeats):
    """Prints it; returns the names of the rows that miss the bar."""
    failed = []
    print("| job | s | busy | within | factor | within, work | factor, work | still, s | |\n"
          "|---|---|---|---|---|---|---|---|---|")
    for line in open(scenes):
        name, _, body = line.rstrip("\n").partition(" ")
        row = judge(daemon, body, repeats)
        within = max(row["wall"][0], row["work"][0] if row["spoiled"] else 0)
        good = within >= WANTED and row["pause"] <= STILL_S
        failed += [] if good else [name]
        print("| {} | {:.1f} | {:.2f} | {:.0f} % | {:.2f} | {:.0f} % | {:.2f} | {:.2f} | {} |".format(
            name, row["seconds"], row["busy"], 100 * row["wall"][0], row["wall"][1],
            100 * row["work"][0], row["work"][1], row["pause"], "spoiled" if row["spoiled"] else ""),
            flush=True)
    return failed


def main(program, scenes, repeats):
    with tempfile.TemporaryDirectory() as folder:
        daemon = Daemon(program, folder + "/store.db")
        try:
            failed = table(daemon, scenes, repeats)
        finally:
            daemon.process.terminate()
            daemon.process.wait()
    print("eta: " + ("off for " + ", ".join(failed) if failed else "every job within the bar"))
    return bool(failed)


sys.exit(main(sys.argv[1], sys.argv[2], int(sys.argv[3])))
