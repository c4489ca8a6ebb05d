"""beamwave's modes and sums beside numpy + FINUFFT, in one process on one core, interleaved; prints tables in Markdown.

    python bench/sum/compare.py BUILD [--small] [--repeats R] [--output FILE]

BUILD is a build directory in which the target bench_sum was built: `cmake --build build --target bench_sum`.
"""
import argparse
import ctypes
import os
import platform
import statistics
import subprocess
import time
from pathlib import Path

os.environ.update(OMP_NUM_THREADS='1', OPENBLAS_NUM_THREADS='1')    # before numpy reads them
import finufft  # noqa: E402
import numpy as np  # noqa: E402

import rival  # noqa: E402

GAMMA, DURATION = 0.2, 46.63                    # about a second of the paper's beam
MODES, SAMPLES = (200, 1000, 4000, 20000, 200000), (2**12, 2**16, 2**20)


class Beamwave:
    def __init__(self, build):
        path = next(Path(build).glob('**/libbench_sum.*'))
        self.library = ctypes.CDLL(str(path.resolve()))

    def job(self, n, samples, tolerance):
        result = np.empty((2, samples))
        self.library.bench_whole_job(n, samples, double(GAMMA), double(DURATION), double(tolerance), address(result))
        return result

    def terms(self, n):
        beta, rate, shapes = np.empty((n, 2)), np.empty(n), np.empty((2, n))
        self.library.bench_terms(n, double(GAMMA), double(DURATION), address(beta), address(rate), address(shapes))
        return beta, rate, shapes

    def sum(self, samples, tolerance, beta, rate, shapes):
        result = np.empty((2, samples))
        self.library.bench_sum_alone(len(rate), samples, address(beta), address(rate), address(shapes), double(DURATION),
                                     double(tolerance), address(result))
        return result


double = ctypes.c_double


def address(array):
    return ctypes.c_void_p(array.ctypes.data)


def seconds(call):
    """Processor time: on a machine that does other things too, what they take is not counted."""
    start = time.thread_time()
    call()
    return time.thread_time() - start


def interleaved(calls, repeats):
    """Medians of calls that take turns."""
    for call in calls:
        call()
    times = [[seconds(call) for call in calls] for _ in range(repeats)]
    return [statistics.median(column) for column in zip(*times)]


def compare(beamwave, n, samples, tolerance, repeats):
    """One row: seconds of both for the whole job and for the sum alone, and how far apart their answers are."""
    transform = rival.Transform(samples, DURATION/samples, tolerance)
    terms = rival.modes(n, GAMMA)
    way = transform.choose(seconds, *terms)
    known = beamwave.terms(n)
    ours, theirs = beamwave.job(n, samples, tolerance), rival.job(n, GAMMA, transform)
    apart = np.abs(ours - theirs).max()/np.abs(ours).max()
    job = interleaved([lambda: beamwave.job(n, samples, tolerance), lambda: rival.job(n, GAMMA, transform)], repeats)
    alone = interleaved([lambda: beamwave.sum(samples, tolerance, *known), lambda: transform(*terms)], repeats)
    return job, alone, way, apart


def about(build):
    """Machine, compiler, flags and versions."""
    model = next((line.split(':')[1].strip() for line in open('/proc/cpuinfo') if line.startswith('model name')),
                 platform.machine())
    cache = {key: value for key, _, value in
             (line.partition('=') for line in (Path(build)/'CMakeCache.txt').read_text().splitlines())}
    compiler = subprocess.run([cache['CMAKE_Fortran_COMPILER:FILEPATH'], '--version'], capture_output=True, text=True,
                              check=True).stdout.splitlines()[0]
    native = cache.get('BEAMWAVE_NATIVE:BOOL', 'OFF')
    return (f'{model}; {compiler}, {cache["CMAKE_BUILD_TYPE:STRING"]}, BEAMWAVE_NATIVE={native}; '
            f'numpy {np.__version__}, finufft {finufft.__version__}, one thread')


def table(beamwave, tolerance, sizes, repeats):
    lines = [f'Accuracy {tolerance:.0e} of the peak. Processor time in ms, medians of {repeats} interleaved runs; '
             'ratio: beamwave over rival.', '',
             '| modes | samples | whole job | rival | ratio | sum alone | FINUFFT | ratio | its way | apart |',
             '|---|---|---|---|---|---|---|---|---|---|']
    for n, samples in sizes:
        job, alone, way, apart = compare(beamwave, n, samples, tolerance, repeats)
        lines.append(f'| {n} | 2^{samples.bit_length() - 1} | {1e3*job[0]:.3g} | {1e3*job[1]:.3g} | {job[0]/job[1]:.2f} '
                     f'| {1e3*alone[0]:.3g} | {1e3*alone[1]:.3g} | {alone[0]/alone[1]:.2f} | {way[0]}, {way[1]} '
                     f'| {apart:.0e} |')
        print(lines[-1], flush=True)
    return '\n'.join(lines) + '\n'


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('build')
    parser.add_argument('--small', action='store_true', help='one small size, to see that it runs')
    parser.add_argument('--repeats', type=int, default=11)
    parser.add_argument('--modes', type=int, nargs='*', default=MODES)
    parser.add_argument('--samples', type=int, nargs='*', default=SAMPLES)
    parser.add_argument('--tolerances', type=float, nargs='*', default=[3e-11, 1e-12])
    parser.add_argument('--output', type=Path)
    options = parser.parse_args()
    sizes = [(n, s) for s in options.samples for n in options.modes]
    if options.small:
        sizes, options.repeats = [(200, 2**12)], 1
    beamwave = Beamwave(options.build)
    text = about(options.build) + '\n\n' + '\n'.join(table(beamwave, t, sizes, options.repeats) for t in options.tolerances)
    print('\n' + text)
    if options.output:
        options.output.write_text(text)


if __name__ == '__main__':
    main()
