"""Corrupted files: finished ones, sealed again or not, and the working data of killed runs.

Every trial ends as refused by an error of ours, or as the analysis that was written. Under ``slow`` there are 1,000; a
small share runs by default.
"""

import contextlib
import json
import random
import shutil

import h5py
import numpy as np
import pytest

import blockstruct as bs
from blockstruct.analysis import IterationDone
from blockstruct.storage.run_folder import Journal
from killed_runs import cases, timeless, wall
from processes import count
from properties import slow_after
from structures import SELF_WEIGHT, edited, model_of, push, single_block, stopping

#: Half of the corruptions are near the beginning, where HDF5 keeps what its readers trust most.
HEAD = 8192


def damage(content, chance, end):
    """Bytes with some of them changed, a sector zeroed, or the end cut off, before a place."""
    content, place = bytearray(content), chance.randrange(max(end, 1))
    match chance.choice(["byte", "byte", "bytes", "sector", "cut", "block"]):
        case "byte":
            content[place] = chance.randrange(256)
        case "bytes":
            for _ in range(16):
                content[chance.randrange(end)] = chance.randrange(256)
        case "sector":
            start = place - place % 512
            content[start : start + 512] = bytes(len(content[start : start + 512]))
        case "cut":
            del content[place:]
        case "block":
            start = chance.randrange(len(content))
            content[place : place + 64] = content[start : start + 64]
    return bytes(content)


def same(one, other):
    """Whether two analyses are the same, to the last bit of their histories."""
    return (
        one.model.hash == other.model.hash
        and list(one) == list(other)
        and all(
            repr((a.status, a.load_factor, a.certificate)) == repr((b.status, b.load_factor, b.certificate))
            and a.history.identical(b.history)
            for a, b in zip(one.values(), other.values(), strict=True)
        )
    )


def judged(read, is_right):
    """Outcome of reading what was attacked."""
    try:
        found = read()
    except bs.errors.BlockstructError:
        return "refused"
    except Exception as error:
        print(repr(error))
        return "raw"
    return "identical" if is_right(found) else "wrong"


def worst(outcomes):
    return next((o for o in ("raw", "wrong", "identical") if o in outcomes), "refused")


def finished(seed, folder, near):
    """Bytes of a finished file are changed."""
    path, original = folder / f"finished-{near}.h5", bs.open_analysis(folder / "whole.h5")
    content = (folder / "whole.h5").read_bytes()
    path.write_bytes(damage(content, random.Random(seed), HEAD if near else len(content)))
    rows = bs.Archive(folder).table().set_index("path")
    listed = rows.loc[[path.name]]
    right = rows.loc[["whole.h5"], "load_factor"].to_numpy()
    outcomes = [
        judged(lambda: bs.open_analysis(path), lambda found: same(found, original)),
        judged(lambda: bs.AnalysisManager(original.model, path), lambda _: path.read_bytes() == content),
        "refused"
        if listed["problem"].all()
        else judged(lambda: listed, lambda t: np.array_equal(t.load_factor, right)),
    ]
    path.unlink()
    return worst(outcomes)


def resealed(seed, folder):
    """What an HDF5 library can change is changed, and the file sealed again: it is what it says, or refused."""
    chance, path = random.Random(seed), folder / "resealed.h5"
    original = bs.open_analysis(folder / "whole.h5")
    edit_any(folder / "whole.h5", chance, path)

    def read():
        bs.check_file(path)
        found = bs.open_analysis(path)
        for result in found.values():
            assert result.history
        return found

    def numbers(analysis):
        return repr([(r.status, r.load_factor, r.certificate and r.certificate.holds) for r in analysis.values()])

    return judged(read, lambda found: numbers(found) == numbers(original))


def edit_any(path, chance, copy=None):
    """Change any item of a file, or of a copy of it."""
    items = []
    with edited(path, copy) as file:
        file.visititems(lambda _, item: items.append(item))
        edit(file, chance.choice(items), chance)


def edit(file, item, chance):
    """Change an attribute, values, the type, or the place of an item."""
    names = [name for name in item.attrs if name.isupper() is False]
    match chance.choice(["attribute", "values", "values", "delete", "move", "group", "type", "text"]):
        case "attribute" if names:
            item.attrs[chance.choice(names)] = chance.choice(["", "{", "[]", "x" * 70_000, 7, np.nan, "9**9**9", "-1"])
        case "values" if isinstance(item, h5py.Dataset) and item.dtype.kind in "fi" and item.size:
            at = tuple(chance.randrange(n) for n in item.shape)
            is_float = item.dtype.kind == "f"
            large = 10**6 if is_float else min(10**6, np.iinfo(item.dtype).max)
            item[at] = chance.choice([0, -1, 99, large, *([np.nan, np.inf, 1e300] if is_float else [])])
        case "delete":
            del file[item.name]
        case "move":
            file.move(item.name, item.name + "%2F")
        case "group" if isinstance(item, h5py.Group):
            for k in range(20_000 if chance.random() < 0.1 else 20):
                item.create_group(f"{k}")
        case "type" if isinstance(item, h5py.Dataset):
            name, shape = item.name, item.shape
            del file[name]
            file.create_dataset(name, shape or (3,), chance.choice(["i1", "f4", "c16", "S3", h5py.string_dtype()]))
        case _:
            file.attrs["cases"] = chance.choice(["[]", '["a"]', json.dumps(["x"] * 20_000), "[" * 50_000])


def working(seed, folder, again):
    """The working data of a killed run are changed: what is recovered was committed."""
    chance, path = random.Random(seed), folder / f"working-{again}" / "wall.h5"
    shutil.rmtree(path.parent, ignore_errors=True)
    shutil.copytree(folder / "killed", path.parent)
    whole = bs.open_analysis(folder / "run.h5")
    place = path.parent / "wall.h5.partial"
    file = chance.choice(sorted(p for p in place.iterdir() if p.suffix == ".journal" or p.name in ("plan", "target")))
    if again and file.suffix == ".journal":
        chain_again(file, chance, place / "plan")
    elif again and file.name == "plan":
        edit_any(file, chance)
    else:
        content = file.read_bytes()
        end = len(content) if chance.random() < 0.5 else min(HEAD, len(content))
        file.write_bytes(damage(content, chance, end))

    def was_committed(result):
        of = whole[result.name]
        cut = of.history.isel(iteration=slice(result.n_iterations)).drop_vars("solver_time")
        return result.status in ("interrupted", of.status) and timeless(result).identical(cut)

    is_right = consistent if again else was_committed
    return judged(lambda: bs.recover(path), lambda found: all(map(is_right, found.values())))


def consistent(result):
    """What a case says of itself does not contradict its history, whoever has sealed it."""
    if result.status == "converged":
        return result.certificate.holds and result.load_factor == float(result.history.load_factor[-1])
    return True


def chain_again(file, chance, plan):
    """Change, swap or drop records, and give them the checksums that go with it."""
    records, seed = [], f"{plan.read_bytes()[-85:].decode()} {file.stem}"
    Journal(file, seed).read(records.append)
    k = chance.randrange(len(records))
    match chance.choice(["content", "swap", "drop", "status"]):
        case "content":
            content = damage(records[k].content, chance, len(records[k].content))
            records[k] = records[k]._replace(content=content)
        case "swap":
            records[k], records[-1] = records[-1], records[k]
        case "drop":
            del records[k]
        case "status" if records[-1].kind == "end":
            ending = json.loads(records[-1].content) | {"load_factor": 0.6392}
            records[-1] = records[-1]._replace(content=json.dumps(ending).encode())
    file.unlink()
    journal = Journal(file, seed)
    for record in records:
        journal.append(record.kind, record.content)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A finished file, and a killed run with what it would have become."""
    folder = tmp_path_factory.mktemp("attack")
    both = [bs.LimitCase(f"rocks, {flow}", SELF_WEIGHT, push(1, 0, 0), flow) for flow in bs.Flow]
    bs.AnalysisManager(model_of(*single_block(0.5, 1.0)), folder / "whole.h5").run(both)
    bs.AnalysisManager(wall(), folder / "run.h5").run(cases())
    stop = stopping(IterationDone, nth=12, error=RuntimeError)
    with contextlib.suppress(RuntimeError):
        bs.AnalysisManager(wall(), folder / "killed" / "wall.h5", listeners=[stop]).run(cases())
    return folder


TRIALS = [(finished, 300, [True]), (finished, 200, [False]), (resealed, 200, []), (working, 200, [False])]


@pytest.mark.parametrize("share", slow_after(0.02, 1.0))
@pytest.mark.parametrize(("trial", "number", "more"), [*TRIALS, (working, 100, [True])])
def test_corrupted_files_are_refused_or_identical(folder, tell, trial, number, more, share):
    seeds = range(round(share * number))
    tell(f"corruptions: {trial.__name__} {''.join(map(str, more))}".strip(), count(trial, seeds, folder, *more))
