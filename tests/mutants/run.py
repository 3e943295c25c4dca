"""Runs the tests against mutants of the code and says which of them live.

    bash tests/mutants/run.sh checker sim

cargo-mutants lists the mutants of an area (a row of areas.json: source files, and the tests
that have to notice when they are wrong); mutant-switch puts all of them into one build.
target/mutants/AREA.jsonl says of each mutant which test caught it.
"""

import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
WORK = TARGET / "mutants"
TREE = WORK / "tree"
# Mutants are built like the tests of .ci/run, but for what a debugger needs.
BUILD = dict(os.environ, CARGO_TARGET_DIR=str(WORK / "build"), CARGO_PROFILE_DEV_DEBUG="none")
# A mutant that takes this many times as long as the code does is caught [1], at the least
# after [s].
PATIENCE, PATIENCE_LEAST = 6, 10.0


def copy_tree():
    """Copies the tree as git sees it, so that the user's is never changed."""
    listed = subprocess.check_output(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, text=True
    )
    kept = set(listed.splitlines())
    for name in kept:
        source, copy = ROOT / name, TREE / name
        if not source.is_file():
            continue
        copy.parent.mkdir(parents=True, exist_ok=True)
        if not copy.exists() or copy.read_bytes() != source.read_bytes():
            shutil.copyfile(source, copy)
    for folder in ("src", "crates", "tests"):
        for path in (TREE / folder).rglob("*.rs"):
            if str(path.relative_to(TREE)) not in kept:
                path.unlink()


def list_mutants(files):
    command = ["cargo", "mutants", "--list", "--json", "--dir", str(ROOT)]
    for name in files:
        command += ["--file", name]
    return json.loads(subprocess.check_output(command, cwd=ROOT, text=True))


def library(name):
    """The library that a source file belongs to."""
    return name.partition("src/")[0] + "src/lib.rs"


def switch(mutants, left_out):
    """Writes the mutants into the copy, and returns where each is, or why it is not."""
    (WORK / "list.json").write_text(json.dumps(mutants))
    (WORK / "left_out.json").write_text(json.dumps(sorted(left_out)))
    report = WORK / "report.json"
    for name in {m["file"] for m in mutants} | {library(m["file"]) for m in mutants}:
        shutil.copyfile(ROOT / name, TREE / name)
    subprocess.run(
        ["cargo", "run", "--quiet", "--release", "--locked", "--manifest-path",
         str(ROOT / "tests/mutants/Cargo.toml"), "--", str(TREE), str(WORK / "list.json"),
         str(WORK / "left_out.json"), str(report)],
        check=True, env=dict(os.environ, CARGO_TARGET_DIR=str(WORK / "switch")),
    )
    return json.loads(report.read_text())


def compile_errors():
    """Where the library does not compile: file and range [bytes] of each error."""
    ran = subprocess.run(
        ["cargo", "check", "--locked", "--workspace", "--lib", "--message-format", "json"],
        cwd=TREE, env=BUILD, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )
    found = []
    for line in ran.stdout.splitlines():
        message = json.loads(line).get("message")
        if not message or message["level"] != "error":
            continue
        spans = [(s["file_name"], s["byte_start"], s["byte_end"], s["is_primary"])
                 for s in message["spans"]]
        if spans:
            found.append((spans, message["message"]))
    if ran.returncode and not found:
        sys.exit("the copy does not compile:\n" + ran.stdout[-2000:])
    return found


def build_switched(mutants):
    """Builds all mutants that compile; returns the places of the others, with the reason."""
    left_out = {}
    while True:
        fates = switch(mutants, left_out)
        errors = compile_errors()
        if not errors:
            break
        before = len(left_out)
        for spans, message in errors:
            left_out.update(blamed(mutants, fates, spans, message))
        print(f"  {len(errors)} errors, {len(left_out)} mutants left out", flush=True)
        if len(left_out) == before:
            sys.exit(f"an error that no mutant is to blame for: {errors[0]}")
    for place, fate in enumerate(fates):
        if isinstance(fate, str):
            left_out[place] = fate
    return left_out


def blamed(mutants, fates, spans, message):
    """The mutants in whose code an error is, or else those around it, the innermost."""
    if message.startswith("non-exhaustive patterns"):
        return blamed_arms(mutants, fates, spans[0])
    for which in ("code", "around"):
        for primary in (True, False):
            hits = [
                (high - low, place)
                for name, start, end, is_primary in spans if is_primary == primary
                for place, fate in enumerate(fates)
                if isinstance(fate, dict) and mutants[place]["file"] == name
                for low, high in [fate[which]] if low < end and start < high
            ]
            if hits:
                least = min(hits)[0]
                return {place: f"does not compile: {message}" for size, place in hits
                        if which == "code" or size == least}
    return {}


def blamed_arms(mutants, fates, span):
    """The mutants that take an arm from a match which has none to spare."""
    name, start, _, _ = span
    arms = [(fate["around"][0], place) for place, fate in enumerate(fates)
            if isinstance(fate, dict) and mutants[place]["file"] == name
            and mutants[place]["genre"] == "MatchArm" and fate["around"][0] > start]
    if not arms:
        return {}
    function = mutants[min(arms)[1]]["function"]["span"]
    return {place: "does not compile: no arm for every value" for _, place in arms
            if mutants[place]["function"]["span"] == function}


def build_tests(areas):
    command = ["cargo", "test", "--locked", "--lib", "--no-run", "--message-format", "json"]
    for name in sorted({name for area in areas for name in area["tests"]}):
        # The others are libraries, with their unit tests.
        if not name.startswith("pickline"):
            command += ["--test", name]
    ran = subprocess.run(command, cwd=TREE, env=BUILD, stdout=subprocess.PIPE, text=True,
                         check=True)
    programs = {}
    for line in ran.stdout.splitlines():
        artifact = json.loads(line)
        if artifact.get("executable") and artifact["profile"]["test"]:
            programs[artifact["target"]["name"]] = artifact["executable"]
    return programs


def build(mutants, areas):
    """The places of mutants that are not built, with the reason, and the programs; as they
    were built before where nothing has changed."""
    key = hashlib.sha256(json.dumps([mutants, [area["tests"] for area in areas]]).encode())
    for path in sorted(path for top in ("Cargo.lock", "src", "crates", "tests")
                       for path in [ROOT / top, *(ROOT / top).rglob("*")]):
        if path.is_file() and "mutants" not in path.parts:
            key.update(path.read_bytes())
    key = key.hexdigest()
    record = WORK / "built.json"
    if record.exists():
        built = json.loads(record.read_text())
        if built["key"] == key:
            return {int(p): why for p, why in built["left_out"].items()}, built["programs"]
    record.unlink(missing_ok=True)
    copy_tree()
    left_out = build_switched(mutants)
    programs = build_tests(areas)
    record.write_text(json.dumps({"key": key, "left_out": left_out, "programs": programs}))
    return left_out, programs


# Tests that run now; they end with this program.
running = set()


def end(*_):
    for process in list(running):
        os.killpg(process.pid, signal.SIGKILL)
    os._exit(130)


def run_tests(program, names, mutant, limit):
    """Whether the tests pass, and the first line that says why not."""
    # That a property fails is enough; for which values it fails is not asked.
    environment = dict(os.environ, RUST_BACKTRACE="0", PROPTEST_MAX_SHRINK_ITERS="0")
    if mutant is not None:
        environment["PICKLINE_MUTANT"] = str(mutant)
    command = [program, "--exact", "-q", "--test-threads", "1", *names]
    process = subprocess.Popen(command, cwd=TREE, env=environment, stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               start_new_session=True)
    running.add(process)
    try:
        output, _ = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return False, "timeout"
    finally:
        running.discard(process)
    if process.returncode == 0:
        return True, ""
    text = output.decode(errors="replace")
    failed = [line.strip() for line in text.splitlines() if line.startswith("    ")]
    known = [name for name in names if name in failed]
    return False, known[0] if known else f"exit code {process.returncode}"


def wanted(modules, test):
    """Whether a test is in one of the modules, or in all but those with a minus sign."""
    left_out = [m[1:] for m in modules if m.startswith("-")]
    named = [m for m in modules if not m.startswith("-")]
    if any(test.startswith(m) for m in left_out):
        return False
    return not named or any(test.startswith(m) for m in named)


def measure(area, programs, jobs):
    """How long each test takes without a mutant [s], in groups that run together."""
    tests = []
    programs = {name: programs[name] for name in area["tests"]}
    for name, program in programs.items():
        listed = subprocess.check_output([program, "--list", "--format", "terse"], cwd=TREE,
                                         text=True)
        for line in listed.splitlines():
            if line.endswith(": test"):
                test = line[: -len(": test")]
                if wanted(area["tests"][name], test):
                    tests.append((name, test))

    def one(test):
        start = time.monotonic()
        passed, why = run_tests(programs[test[0]], [test[1]], None, 600)
        if not passed:
            sys.exit(f"{test}: fails without a mutant: {why}")
        return time.monotonic() - start

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        times = list(pool.map(one, tests))
    groups = []
    for name in programs:
        quick = [(t, s) for t, s in zip(tests, times) if t[0] == name and s < 0.3]
        for start in range(0, len(quick), 12):
            part = quick[start:start + 12]
            groups.append((name, [t[1] for t, _ in part], sum(s for _, s in part)))
        groups += [(name, [t[1]], s) for t, s in zip(tests, times)
                   if t[0] == name and s >= 0.3]
    groups.sort(key=lambda group: group[2])
    return groups


class Runner:
    """Runs mutants; tries first what has caught others of the same file."""

    def __init__(self, programs, groups):
        self.programs, self.groups = programs, groups
        self.caught = {}
        self.lock = threading.Lock()

    def order(self, file):
        with self.lock:
            counts = dict(self.caught.get(file, {}))
        # What it costs to catch one mutant, guessed.
        def cost(place):
            return (self.groups[place][2] + 0.05) / (counts.get(place, 0) + 0.2)
        return sorted(range(len(self.groups)), key=cost)

    def run(self, place, mutant):
        for group in self.order(mutant["file"]):
            name, tests, seconds = self.groups[group]
            limit = max(PATIENCE_LEAST, PATIENCE * seconds)
            passed, why = run_tests(self.programs[name], tests, place, limit)
            if not passed:
                with self.lock:
                    counts = self.caught.setdefault(mutant["file"], {})
                    counts[group] = counts.get(group, 0) + 1
                return {"fate": "caught", "by": f"{name} {why}"}
        return {"fate": "alive"}


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("area", nargs="*", help="rows of areas.json; all if none is named")
    parser.add_argument("--every", type=int, default=1, metavar="N",
                        help="take every Nth mutant only")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(),
                        help="tests that run at once")
    parser.add_argument("--resume", action="store_true",
                        help="keep what an earlier run caught, and try the other mutants")
    chosen = parser.parse_args()
    signal.signal(signal.SIGINT, end)
    signal.signal(signal.SIGTERM, end)
    areas = json.loads((pathlib.Path(__file__).parent / "areas.json").read_text())
    unknown = [name for name in chosen.area if name not in areas]
    if unknown:
        parser.error(f"no area {unknown[0]}; there are {', '.join(areas)}")
    WORK.mkdir(parents=True, exist_ok=True)
    mutants, rows = [], {}
    for name, area in areas.items():
        listed = list_mutants(area["files"])[:: chosen.every]
        rows[name] = range(len(mutants), len(mutants) + len(listed))
        mutants += listed
    print(f"{len(mutants)} mutants", flush=True)
    left_out, programs = build(mutants, areas.values())
    print(f"{len(left_out)} not built", flush=True)
    for name in chosen.area or areas:
        area = areas[name]
        run_area(name, area, rows[name], mutants, left_out, programs, chosen)


def run_area(name, area, places, mutants, left_out, programs, chosen):
    groups = measure(area, programs, chosen.jobs)
    print(f"{name}: {len(places)} mutants, {sum(len(g[1]) for g in groups)} tests of "
          f"{sum(g[2] for g in groups):.0f} s", flush=True)
    path = WORK / f"{name}.jsonl"
    known = {}
    if chosen.resume and path.exists():
        earlier = map(json.loads, path.read_text().splitlines())
        known = {r["name"]: r for r in earlier if r["fate"] == "caught"}
    path.write_text("".join(json.dumps(r) + "\n" for r in known.values()))
    runner = Runner(programs, groups)

    def one(place):
        mutant = mutants[place]
        if place in left_out:
            return {"fate": "not built", "why": left_out[place]}
        return known.get(mutant["name"]) or runner.run(place, mutant)

    counts = {"caught": 0, "alive": 0, "not built": 0}
    with path.open("a") as out, concurrent.futures.ThreadPoolExecutor(chosen.jobs) as pool:
        for place, result in zip(places, pool.map(one, places)):
            result = {**result, "name": mutants[place]["name"]}
            counts[result["fate"]] += 1
            if result["name"] not in known:
                out.write(json.dumps(result) + "\n")
                out.flush()
            if result["fate"] == "alive":
                print(f"  alive: {result['name']}", flush=True)
    viable = counts["caught"] + counts["alive"]
    print(f"  {counts}, {100 * counts['caught'] / max(viable, 1):.1f} % caught", flush=True)


if __name__ == "__main__":
    main()
