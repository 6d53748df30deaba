"""What a call does to the interpreter: locks, signals, threads, memory, functions that raise."""

import ctypes
import gc
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
import weakref

import numpy as np
import pytest

import gpvc


def texture(city, images=None, **options):
    scene = city.scene if images is None else city.scene.with_images(images)
    return gpvc.texture(city.mesh.vertices, city.mesh.faces, scene, **options)


def test_what_a_function_of_images_raises_reaches_the_caller(city):
    class Broken(Exception):
        pass

    def image(i):
        if i == 3:
            raise Broken("disk on fire")
        return city.images[i]

    with pytest.raises(Broken, match="disk on fire") as raised:
        texture(city, image)
    assert any("images(3)" in note for note in raised.value.__notes__)
    assert (texture(city, lambda i: city.images[i]).labels == texture(city).labels).all(), "the module works on"


def test_progress_is_told_and_can_stop_a_run(city):
    told = []
    texture(city, progress=lambda *step: told.append(step))
    stages = list(dict.fromkeys(stage for stage, _, _ in told))
    assert stages == ["read", "face graph", "see", "choose", "bake"]
    assert all(0 <= done <= max(total, done) for _, done, total in told)
    assert any(done == total > 0 for stage, done, total in told if stage == "bake")

    def stop(stage, done, total):
        if stage == "see":
            raise StopIteration("enough")

    with pytest.raises(StopIteration, match="enough"):
        texture(city, progress=stop)


def test_progress_shows_itself(city, capsys):
    texture(city, progress=True)
    assert "bake" in capsys.readouterr().err
    texture(city)
    shown = capsys.readouterr()
    assert shown.err == shown.out == "", "nothing is printed that was not asked for"


def test_other_python_threads_go_on(city):
    counted, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    began = time.perf_counter()
    texture(city)
    seconds = time.perf_counter() - began
    done.set()
    thread.join()
    assert counted[0] > 50 * seconds, (counted[0], seconds)


def test_several_threads_get_the_same_results(city):
    expected = texture(city)
    results, errors = {}, []

    def run(n):
        try:
            images = (lambda i: city.images[i]) if n % 2 else None
            results[n] = texture(city, images)
            assert len(list(gpvc.visibility(city.mesh.vertices, city.mesh.faces, city.scene))) == 6
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=run, args=(n,)) for n in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors
    for result in results.values():
        assert (result.labels == expected.labels).all() and (result.pages[0] == expected.pages[0]).all()


def test_a_function_of_images_may_use_the_module_itself(city):
    def image(i):
        next(gpvc.visibility(city.mesh.vertices, city.mesh.faces, city.scene))
        return city.images[i]

    assert (texture(city, image).labels == texture(city).labels).all()


def test_a_generator_may_go_on_in_another_thread(city):
    views = gpvc.visibility(city.mesh.vertices, city.mesh.faces, city.scene)
    first, second = [next(views)], []
    thread = threading.Thread(target=lambda: second.extend(views))
    thread.start()
    thread.join()
    expected = list(gpvc.visibility(city.mesh.vertices, city.mesh.faces, city.scene))
    assert all((a == b).all() for a, b in zip(first + second, expected))


@pytest.mark.parametrize("where", ["library", "function"])
def test_ctrl_c_raises_within_a_second(city, where):
    """In a process of its own: during the library's work, or while a function of the caller's takes its time."""
    program = textwrap.dedent(
        f"""
        import sys, threading, time
        import numpy as np
        import gpvc
        mesh, scene = gpvc.read_mesh({str(city.folder / "mesh.ply")!r}), gpvc.read_scene({str(city.folder / "colmap")!r})
        n = 12  # a larger mesh: copies of the city beside each other, and its photos, often
        if {where!r} == "library":
            def copy(i):
                return mesh.vertices + [60 * (i % n), 60 * (i // n), 0]
            vertices = np.concatenate([copy(i) for i in range(n * n)])
            faces = np.concatenate([mesh.faces + i * len(mesh.vertices) for i in range(n * n)])
            poses = np.concatenate([[v.camera_from_world for v in scene.views]] * 60)
            images = [v.photo for v in scene.views] * 60
            call = lambda: gpvc.texture(vertices, faces, images, scene.views[0].K, poses, scene.views[0].distortion, allow_unseen=True)
        else:
            def image(i):
                time.sleep(2)
                return np.zeros((320, 480, 3), np.uint8)
            call = lambda: gpvc.texture(mesh.vertices, mesh.faces, scene.with_images(image))
        print("begins", flush=True)
        try:
            call()
            print("ended")
        except KeyboardInterrupt:
            print("interrupted", time.time(), flush=True)
        """
    )
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begins\n", process.stderr.read()
    time.sleep(1.5)
    sent = time.time()
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=120)
    assert out.startswith("interrupted "), (out, err)
    assert float(out.split()[1]) - sent < 1, "seconds until KeyboardInterrupt"
    assert process.returncode == 0, err


def resident_bytes():
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)  # what is free goes back, or its scattering over the threads' heaps would count
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_nothing_leaks(city):
    masks = [np.ones((320, 480), bool)] * 6

    def once():
        views = [view.camera_from_world for view in city.scene.views]
        texture(city, [image.astype(np.float32) / 255 for image in city.images], progress=lambda *_: None)
        gpvc.texture(city.mesh.vertices, city.mesh.faces, lambda i: city.images[i], city.scene.views[0].K, views, masks=masks)
        sum(ids.sum() for ids in gpvc.face_ids(city.mesh.vertices, city.mesh.faces, city.scene))
        gpvc.coverage(city.mesh.vertices, city.mesh.faces, city.scene)
        with pytest.raises(ZeroDivisionError):
            texture(city, lambda i: 1 / 0)

    def growth_of_four_rounds():
        before = resident_bytes()
        for _ in range(4):
            once()
        return resident_bytes() - before

    once()
    references = [sys.getrefcount(image) for image in city.images]
    # What each round kept, a photo, a page or a mesh, would be 5 MB or more, every time; heaps and drivers grow now and then.
    grown = []
    while len(grown) < 4 and (not grown or min(grown) >= 8e6):
        grown.append(growth_of_four_rounds())
    assert min(grown) < 8e6, f"four rounds of calls, time and again: {grown} bytes more"
    assert [sys.getrefcount(image) for image in city.images] == references


def test_what_is_given_is_let_go(city):
    class Function:
        def __call__(self, i):
            return city.images[i]

    function = Function()
    watched = weakref.ref(function)
    result = texture(city, function)
    del function
    gc.collect()
    assert watched() is None and len(result.pages) == 1
