#!/usr/bin/env python3
"""photos_oracle.py COLMAP_TXT MESH --images DIR [OPTION]...

Random points of a mesh, asked of `gpvc photos` and of an oracle that shares no code with it: every photo listed has to show the
point, and none that shows it may be missing. COLMAP_TXT: cameras.txt and images.txt; MESH: binary PLY of triangles.

  --points N    how many, drawn by area with a fixed seed [1000]
  --gpvc FILE   the gpvc to run [build/release/app/gpvc]
  --classes     also compare the class of the point's face with `gpvc visibility`, which is rendered
  --broken      the oracle leaves out every tenth face, to see that the comparison can fail

The oracle projects all corners in doubles, takes the faces whose bounds hold the point's pixel, and cuts them with the segment from
camera to point. What doubles cannot decide for certain, fractions of unlimited size do. A photo shows a point that lies before the
camera, in the frame, within the photo once distorted, on a face that turns its front, and with no other face in between.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
from fractions import Fraction

import numpy as np


def read_ply(path):
    with open(path, 'rb') as file:
        data = file.read()
    end = data.index(b'end_header') + len(b'end_header')
    end = data.index(b'\n', end - 1) + 1
    sections, fields = [], None
    for line in data[:end].decode('ascii', 'replace').splitlines():
        words = line.split()
        if words[:1] == ['element']:
            fields = []
            sections.append((words[1], int(words[2]), fields))
        elif words[:1] == ['property']:
            fields.append(words[1:])
    types = {'float': '<f4', 'float32': '<f4', 'double': '<f8', 'float64': '<f8', 'uchar': 'u1', 'uint8': 'u1', 'int': '<i4',
             'int32': '<i4', 'uint': '<u4', 'uint32': '<u4', 'char': 'i1', 'short': '<i2', 'ushort': '<u2'}
    at, found = end, {}
    for name, count, fields in sections:
        if name == 'face':
            kind = np.dtype([('n', types[fields[0][1]]), ('v', types[fields[0][2]], 3)])
        else:
            kind = np.dtype([(field[-1], types[field[0]]) for field in fields])
        found[name] = np.frombuffer(data, kind, count, at)
        at += kind.itemsize * count
    vertices = np.stack([found['vertex'][axis].astype(np.float64) for axis in 'xyz'], axis=1)
    if not (found['face']['n'] == 3).all():
        sys.exit(f'{path}: expected triangles')
    return vertices, found['face']['v'].astype(np.int64)


def rotation(q):
    w, x, y, z = np.array(q) / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


class View:
    def __init__(self, name, camera, q, t):
        self.name, self.t = name, np.array(t)
        self.rotation = rotation(q)
        self.centre = -self.rotation.T @ self.t
        model, self.width, self.height, p = camera
        self.k = [0.0, 0.0, 0.0, 0.0]
        if model == 'OPENCV':
            self.fx, self.fy, self.cx, self.cy, *self.k = p
        elif model == 'PINHOLE':
            self.fx, self.fy, self.cx, self.cy = p
        else:
            sys.exit(f'expected cameras of the models OPENCV or PINHOLE, found {model}')
        # Beyond the radius where r (1 + k1 r^2 + k2 r^4) stops growing the lens folds back and shows nothing.
        turns = [r for r in np.roots([5 * self.k[1], 3 * self.k[0], 1]) if abs(r.imag) < 1e-12 and r.real > 0]
        self.most = min([r.real for r in turns], default=np.inf)

    def project(self, points):
        c = (points - self.centre) @ self.rotation.T
        with np.errstate(divide='ignore', invalid='ignore'):
            return c[:, 0] / c[:, 2] * self.fx + self.cx, c[:, 1] / c[:, 2] * self.fy + self.cy, c[:, 2]

    def photo(self, u, v):
        """Where the photo has a position of the frame; None beyond the fold."""
        x, y = (u - self.cx) / self.fx, (v - self.cy) / self.fy
        k1, k2, p1, p2 = self.k
        r2 = x * x + y * y
        if r2 >= self.most:
            return None
        radial = 1 + k1 * r2 + k2 * r2 * r2
        return (self.fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + self.cx,
                self.fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + self.cy)


def read_views(folder):
    def lines(name):
        with open(os.path.join(folder, name), encoding='utf-8') as file:
            return [line.rstrip('\n') for line in file if not line.startswith('#')]
    cameras = {}
    for line in lines('cameras.txt'):
        if line.split():
            number, model, width, height, *p = line.split()
            cameras[number] = (model, int(width), int(height), [float(x) for x in p])
    views = {}
    rows = lines('images.txt')
    for line in rows[::2]:
        if line.split():
            _, *pose, camera, name = line.split(None, 9)
            pose = [float(x) for x in pose]
            views[name] = View(name, cameras[camera], pose[:4], pose[4:])
    return views


def exact(point):
    return [Fraction(float(x)) for x in point]


def orientation(a, b, c, d):
    """The sign of det(b - a, c - a, d - a), and whether doubles were too coarse for it."""
    u, v, w = b - a, c - a, d - a
    cross = np.cross(u, v)
    value = float(cross @ w)
    size = float((np.abs(u[[1, 2, 0]] * v[[2, 0, 1]]) + np.abs(u[[2, 0, 1]] * v[[1, 2, 0]])) @ np.abs(w))
    scale = max(float(np.abs(p).max()) for p in (a, b, c, d))
    if abs(value) > 1e-13 * size + 1e-15 * scale * float(np.abs(u).max() * np.abs(v).max() + np.abs(w).max() ** 2):
        return (value > 0) - (value < 0), False
    a, b, c, d = map(exact, (a, b, c, d))
    u, v, w = ([p[i] - a[i] for i in range(3)] for p in (b, c, d))
    value = (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]))
    return (value > 0) - (value < 0), True


class Oracle:
    def __init__(self, vertices, faces, broken):
        self.vertices, self.faces = vertices, faces
        self.kept = np.arange(len(faces)) % 10 != 3 if broken else np.ones(len(faces), bool)
        self.exact_tests = 0

    def distance(self, face, point):
        """Of the point from the plane of the face, or infinity where it does not project into the face."""
        a, b, c = self.vertices[self.faces[face]]
        normal = np.cross(b - a, c - a)
        if not normal.any():
            return np.inf
        weights = np.linalg.solve(np.stack([b - a, c - a, normal], axis=1), point - a)
        inside = weights[0] > -1e-9 and weights[1] > -1e-9 and weights[0] + weights[1] < 1 + 1e-9
        return abs(weights[2]) * np.linalg.norm(normal) if inside else np.inf

    def faces_at(self, points):
        """Of each point all faces that it lies on: doubled faces and walls in one plane exist."""
        corners = self.vertices[self.faces]
        low, high = corners.min(axis=1) - 1e-9, corners.max(axis=1) + 1e-9
        scale = np.abs(self.vertices).max()
        found = []
        for point in points:
            near = np.flatnonzero(((low <= point) & (high >= point)).all(axis=1))
            found.append([f for f in near if self.distance(f, point) < 1e-12 * scale])
        return found

    def shown(self, view, points, own):
        """Per point 'shown', or why not."""
        u, v, z = view.project(self.vertices)
        fu, fv, fz = u[self.faces], v[self.faces], z[self.faces]
        ahead = (fz > 0).all(axis=1)
        crossing = (fz > 0).any(axis=1) & ~ahead
        low_u, high_u = np.where(ahead, fu.min(axis=1), -np.inf), np.where(ahead, fu.max(axis=1), np.inf)
        low_v, high_v = np.where(ahead, fv.min(axis=1), -np.inf), np.where(ahead, fv.max(axis=1), np.inf)
        usable = (ahead | crossing) & self.kept
        pu, pv, pz = view.project(points)
        answers = []
        for n, point in enumerate(points):
            answers.append(self.answer(view, point, own[n], (pu[n], pv[n], pz[n]), usable, low_u, high_u, low_v, high_v))
        return answers

    def answer(self, view, point, own, at, usable, low_u, high_u, low_v, high_v):
        x, y, z = at
        if not z > 0:
            return 'behind'
        if not (0 <= x <= view.width and 0 <= y <= view.height):
            return 'outside-frame'
        photo = view.photo(x, y)
        if photo is None or not (0 <= photo[0] <= view.width and 0 <= photo[1] <= view.height):
            return 'outside-photo'
        if not any(orientation(*self.vertices[self.faces[f]], view.centre)[0] > 0 for f in own):
            return 'back'
        near = np.flatnonzero(usable & (low_u <= x + 1e-6) & (high_u >= x - 1e-6) & (low_v <= y + 1e-6) & (high_v >= y - 1e-6))
        for face in near:
            if face not in own and self.cuts(view.centre, point, face):
                return 'hidden'
        return 'shown'

    def cuts(self, eye, point, face):
        """Whether the face cuts the open segment."""
        a, b, c = self.vertices[self.faces[face]]
        side_eye, e1 = orientation(a, b, c, eye)
        side_point, e2 = orientation(a, b, c, point)
        self.exact_tests += e1 + e2
        if side_eye == 0 or side_eye == side_point or side_point == 0:
            return False
        signs = []
        for p, q in ((a, b), (b, c), (c, a)):
            sign, rounded = orientation(eye, point, p, q)
            self.exact_tests += rounded
            signs.append(sign)
        return not (min(signs) < 0 < max(signs))


def random_points(vertices, faces, count):
    random = np.random.default_rng(48)
    corners = vertices[faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    chosen = random.choice(len(faces), count, p=area / area.sum())
    weights = random.dirichlet([1, 1, 1], count)
    return np.einsum('nk,nkd->nd', weights, corners[chosen]), chosen


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument('scene')
    parser.add_argument('mesh')
    parser.add_argument('--images', required=True)
    parser.add_argument('--points', type=int, default=1000)
    parser.add_argument('--gpvc', default=os.path.join(os.path.dirname(__file__), '../build/release/app/gpvc'))
    parser.add_argument('--classes', action='store_true')
    parser.add_argument('--broken', action='store_true')
    options = parser.parse_args()
    vertices, faces = read_ply(options.mesh)
    views = read_views(options.scene)
    points, chosen = random_points(vertices, faces, options.points)
    common = [options.scene, options.mesh, '--images', options.images, '--quiet']
    with tempfile.TemporaryDirectory() as folder:
        asked = [f'--at={x!r},{y!r},{z!r}' for x, y, z in points.tolist()]
        out = os.path.join(folder, 'answers.json')
        subprocess.run([options.gpvc, 'photos', *common, *asked, '--json', out], check=True, stdout=subprocess.DEVNULL)
        with open(out, encoding='utf-8') as file:
            answers = json.load(file)['points']
        classes = {}
        if options.classes:
            seen = os.path.join(folder, 'seen')
            subprocess.run([options.gpvc, 'visibility', *common, '-o', seen], check=True, stdout=subprocess.DEVNULL)
            classes = {name: np.load(os.path.join(seen, 'visibility', name + '.npy')) for name in views}
    oracle = Oracle(vertices, faces, options.broken)
    own = oracle.faces_at(points)
    for n, face in enumerate(chosen):
        if face not in own[n]:
            own[n].append(face)
    told = [{photo['name']: photo for photo in answer['photos']} for answer in answers]
    far = max(answer['distance'] for answer in answers)
    pairs = listed = wrong = missing = other = classed = differing = 0
    for name, view in views.items():
        for n, truth in enumerate(oracle.shown(view, points, own)):
            photo = told[n][name]
            pairs += 1
            listed += photo['shows']
            if photo['shows'] != (truth == 'shown'):
                wrong += photo['shows']
                missing += not photo['shows']
                print(f'{name}, point {n}, face {chosen[n]}: gpvc says {photo["reason"]}, the oracle {truth}')
            elif photo['reason'].replace('edge-on', 'back') != truth:
                other += 1
            if name in classes:
                classed += 1
                differing += {'hidden': 0, 'partial': 1, 'full': 2}[photo['class']] != classes[name][photo['face']]
    print(f'{len(points)} points, {len(views)} photos, {pairs} pairs; points are {far:.3g} from where they were asked for')
    print(f'{listed} photos listed, {wrong} of them do not show the point; {missing} that show it are missing')
    print(f'{other} of those not listed have another reason; {oracle.exact_tests} tests in fractions')
    if classes:
        print(f'{classed} classes of faces compared with the rendered ones: {differing} differ')
    sys.exit(1 if wrong + missing + differing > 0 else 0)


if __name__ == '__main__':
    main()
