"""Progress, as the caller wants it."""

import sys

try:
    from tqdm.auto import tqdm
except ImportError:
    tqdm = None


class _Bars:
    """One bar of tqdm for each stage that counts something."""

    def __init__(self):
        self.stage, self.bar = None, None

    def __call__(self, stage, done, total):
        if stage != self.stage:
            self.close()
            self.stage = stage
        if not total:
            return
        if self.bar is None:
            self.bar = tqdm(total=total, desc=stage, leave=True)
        self.bar.total = total
        self.bar.update(done - self.bar.n)

    def close(self):
        if self.bar is not None:
            self.bar.close()
        self.bar = None


class _Lines:
    """A line for each stage, where there is no tqdm."""

    def __init__(self):
        self.stage = None

    def __call__(self, stage, done, total):
        if stage != self.stage:
            print(f"gpvc: {stage}", file=sys.stderr, flush=True)
        self.stage = stage

    def close(self):
        pass


class Progress:
    """`with Progress(wanted) as call:` gives what the library calls, or None."""

    def __init__(self, wanted):
        if wanted is not None and not isinstance(wanted, bool) and not callable(wanted):
            raise TypeError("progress: expected True, False or a function of (stage, done, total)")
        self.shown = (_Bars() if tqdm else _Lines()) if wanted is True else None
        self.call = wanted if callable(wanted) else self.shown

    def __enter__(self):
        return self.call

    def __exit__(self, *_):
        if self.shown:
            self.shown.close()
