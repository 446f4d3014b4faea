"""The interpreter's lock is released, no thread is left over, and a process that forks goes on."""

import multiprocessing
import os
import subprocess
import sys
import threading
import time
import warnings

import pytest

import courier

# How often it is looked whether a thread has ended that was told to: some ten thousand times longer than one takes.
PATIENCE_LOOKS = 20_000


def test_another_thread_goes_on(stage):
    """The other thread counts on while a recording is diagnosed.

    No thread is made to give up the lock by the interpreter here, so that nothing is counted unless the call itself gives it up.
    """
    recording = courier.read(stage)
    count, stop, counting = 0, threading.Event(), threading.Event()

    def work():
        nonlocal count
        while not stop.is_set():
            count += 1
            counting.set()
            # Gives up the lock, and asks for it again.
            time.sleep(0)

    usual = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    other = threading.Thread(target=work)
    try:
        other.start()
        counting.wait()
        before = count
        held = sum(range(1_000_000))
        assert held and count == before, "the lock was given up without a call"
        # The call alone: what the package does besides may give up the lock.
        courier._native.diagnose(recording._native, [str(stage)], None)
        assert count > before
    finally:
        stop.set()
        sys.setswitchinterval(usual)
        other.join()


# Threads of a process that has just begun, before and after it has diagnosed.
LEFT_OVER = """
import os, sys, time, courier
threads = lambda: len(os.listdir("/proc/self/task"))
before = threads()
courier.diagnose(sys.argv[1])
for _ in range(int(sys.argv[2])):
    if threads() == before:
        break
    # One that was told to end is listed until it has.
    time.sleep(0.001)
print(threads() - before)
"""


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="this system does not list a process's threads")
def test_no_thread_is_left_over(stage):
    words = [sys.executable, "-c", LEFT_OVER, stage, str(PATIENCE_LOOKS)]
    ran = subprocess.run(words, capture_output=True, text=True, check=True)
    assert ran.stdout == "0\n"


def test_side_by_side(stage):
    answers = [None, None]

    def work(place):
        answers[place] = courier.diagnose(stage).to_json()

    both = [threading.Thread(target=work, args=(place,)) for place in range(2)]
    for thread in both:
        thread.start()
    for thread in both:
        thread.join()
    assert answers[0] == answers[1] == courier.diagnose(stage).to_json()


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="this system does not fork")
def test_a_child_of_a_process_that_has_diagnosed(stage):
    wanted = courier.diagnose(stage).to_json()
    context = multiprocessing.get_context("fork")
    with warnings.catch_warnings():
        # Newer interpreters warn of forks beside threads that NumPy may have.
        warnings.simplefilter("ignore", DeprecationWarning)
        with context.Pool(1) as pool:
            # A child that waits for threads which it has not would never answer.
            assert pool.apply_async(_diagnosed, (str(stage),)).get(timeout=300) == wanted


def _diagnosed(path):
    return courier.diagnose(path).to_json()
