#!/usr/bin/env python3
"""A navigator of one's own, as a program beside ductloop: standard library and numpy only.

    ductloop run scenarios/straight.toml --navigator 'python3 examples/own_navigator.py'

It reads docs/navigator-protocol.md's messages from standard input and answers on standard output. How it finds its way: the
brightest row of each column is taken for a stripe; with each laser's plane such a pixel gives a point, and the laser for which
the points of one side of the image lie on a straight wall is the right one. Walls to the left and right give offset and heading,
and a proportional law steers. It knows straight ducts only, and stops where it has seen no wall for half a second.
"""

import json
import math
import struct
import sys

import numpy as np

HELLO, READY, FRAME, COMMAND, END = 1, 2, 3, 4, 5
UNKNOWN, TRACKING, COASTING, STOPPED = 0, 1, 2, 3


def read_message(stream):
    """The next message's kind and body; None at the end of the stream."""
    head = stream.read(5)
    if len(head) < 5:
        return None
    length, kind = struct.unpack("<IB", head)
    return kind, stream.read(length - 1)


def write_message(stream, kind, body):
    stream.write(struct.pack("<IB", len(body) + 1, kind) + body)
    stream.flush()


class Rig:
    """Pixels to points in the robot's frame: x forward, y left, z up, in metres. Distortion is not taken out."""

    def __init__(self, hello):
        camera, mount = hello["camera"], hello["mount"]
        self.fx, self.fy = camera["focal_px"]
        self.cx, self.cy = camera["centre_px"]
        self.position = np.array(mount["position_in_base_m"])
        self.roll = mount["roll_rad"]
        self.lasers = [(np.array(laser["normal_in_camera"]), laser["offset_m"]) for laser in hello["lasers"]]

    def base_from_camera(self, pan, tilt):
        def rz(a):
            return np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])

        ry = np.array([[math.cos(tilt), 0, math.sin(tilt)], [0, 1, 0], [-math.sin(tilt), 0, math.cos(tilt)]])
        axes = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
        return rz(pan) @ ry @ axes @ rz(self.roll)

    def points(self, u, v, laser, pan, tilt):
        normal, offset = self.lasers[laser]
        rays = np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy, np.ones_like(u)], axis=1)
        along = rays @ normal
        along[np.abs(along) < 1e-9] = 1e-9
        depth = offset / along
        points = (rays * depth[:, None]) @ self.base_from_camera(pan, tilt).T + self.position
        return points[(depth > 0.1) & (depth < 2.0)]


def fit_wall(points, height_m):
    """y = a + b x through the points that are no floor and no ceiling, outliers dropped: (a, b, how many, rms)."""
    points = points[(points[:, 2] > 0.02) & (points[:, 2] < height_m)]
    keep = np.ones(len(points), bool)
    line = None
    for limit_m in (0.05, 0.02, 0.01, 0.005):
        if keep.sum() < 30:
            return None
        x, y = points[keep, 0], points[keep, 1]
        b, a = np.polyfit(x, y, 1)
        off = np.abs(points[:, 1] - a - b * points[:, 0])
        keep = off < limit_m
        line = (a, b, int(keep.sum()), float(np.sqrt(np.mean(off[keep] ** 2))) if keep.any() else 1.0)
    return line if line[2] >= 30 and line[3] < 0.004 and abs(line[1]) < 0.6 else None


class Navigator:
    HEIGHT_M = 0.28  # above this a point is not taken for a wall's

    def __init__(self, hello):
        self.rig = Rig(hello)
        self.drive = hello["drive"]
        self.target_speed = hello["speed_m_s"]
        self.width = hello["duct_width_m"]
        self.period = hello["ticks_per_frame"] / hello["ticks_per_s"]
        self.speed = self.yaw_rate = 0.0
        self.errors = None
        self.unseen_s = 0.0

    def see(self, image, pan, tilt):
        """(lateral, heading), or None."""
        rows = image.astype(np.float64)
        background = np.median(rows, axis=0)
        peak = rows.argmax(axis=0)
        columns = np.arange(image.shape[1])
        height = rows[peak, columns] - background
        # Centre of gravity of the five rows about the brightest.
        around = np.clip(peak[None, :] + np.arange(-2, 3)[:, None], 0, image.shape[0] - 1)
        weight = np.clip(rows[around, columns[None, :]] - background, 0, None)
        centre = (weight * around).sum(axis=0) / np.maximum(weight.sum(axis=0), 1e-9)
        lit = height > 0.12 * rows.max()
        walls = []
        for half in (columns < self.rig.cx, columns > self.rig.cx):
            chosen = lit & half
            u, v = columns[chosen].astype(float), centre[chosen]
            side = 1 if half[0] else -1  # the image's left half looks to the left
            fits = [fit_wall(self.rig.points(u, v, i, pan, tilt), self.HEIGHT_M) for i in range(len(self.rig.lasers))]
            fits = [fit for fit in fits if fit is not None and side * fit[0] > 0]
            if fits:
                walls.append((side, max(fits, key=lambda fit: fit[2])))
        if not walls:
            return None
        laterals, headings, weights = [], [], []
        for side, (a, b, count, _) in walls:
            heading = -math.atan(b)
            distance = side * a * math.cos(heading)  # from the robot to that wall
            laterals.append(side * (self.width / 2 - distance))
            headings.append(heading)
            weights.append(count)
        return float(np.average(laterals, weights=weights)), float(np.average(headings, weights=weights))

    def steer(self, seen):
        if seen is not None:
            self.errors, self.unseen_s = seen, 0.0
        else:
            self.unseen_s += self.period
            if self.errors is not None:  # carried on by what was commanded
                lateral, heading = self.errors
                self.errors = (lateral + self.speed * self.period * math.sin(heading), heading + self.yaw_rate * self.period)
        if self.errors is None or self.unseen_s > 0.5:
            self.speed = self.yaw_rate = 0.0
            return UNKNOWN if self.errors is None else STOPPED
        lateral, heading = self.errors
        # Along the path: lateral'' + 10 lateral' + 25 lateral = 0, critically damped.
        wanted = -self.speed * (25.0 * lateral + 10.0 * heading)
        # One share of what the wheels can do for the turn, the rest for the speed.
        alpha, a = self.drive["max_yaw_acceleration_rad_s2"] * self.period, 0.5 * self.drive["max_acceleration_m_s2"] * self.period
        self.yaw_rate += min(max(wanted - self.yaw_rate, -alpha), alpha)
        self.speed += min(max(self.target_speed - self.speed, -a), a)
        return TRACKING if seen is not None else COASTING

    def on_frame(self, body):
        tick, _left, _right, pan, tilt, width, height, max_dn, size, _ = struct.unpack_from("<QqqddIIHBB", body)
        image = np.frombuffer(body, "<u1" if size == 1 else "<u2", width * height, 52).reshape(height, width)
        seen = self.see(image, pan, tilt)
        state = self.steer(seen)
        half, radius, nan = self.drive["effective_track_m"] / 2, self.drive["wheel_radius_m"], math.nan
        left, right = (self.speed - half * self.yaw_rate) / radius, (self.speed + half * self.yaw_rate) / radius
        lateral, heading = seen if seen is not None else (nan, nan)
        return struct.pack("<8dB7x", left, right, pan, tilt, nan, nan, lateral, heading, state)


def main():
    stdin, stdout = sys.stdin.buffer, sys.stdout.buffer
    navigator = None
    while (message := read_message(stdin)) is not None:
        kind, body = message
        if kind == HELLO:
            navigator = Navigator(json.loads(body))
            write_message(stdout, READY, json.dumps({"protocol": 1, "name": "column maxima"}).encode())
        elif kind == FRAME:
            write_message(stdout, COMMAND, navigator.on_frame(body))
        elif kind == END:
            break


if __name__ == "__main__":
    main()
