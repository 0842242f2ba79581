"""A complete engine for the protocol of ``tt-precise engines``, with the standard library only.

Rigid contact, Coulomb friction (below 1 cm/s proportional to the gliding speed, so there is no
sticking), the Runge-Kutta method of order 4.

    tt-precise engines --run "python examples/engine.py" --test flight --test ice --test gliding
"""

import json
import sys
from math import hypot, sqrt

SLOW = 1e-2  # m/s


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def rates(job, y):
    """Rates of the quaternion (scalar first), the angular velocity and the velocity of CM."""
    body, g = job["body"], job["gravity"]
    m, R, I1, I3 = body["mass"], body["radius"], body["I1"], body["I3"]
    (qw, qx, qy, qz), omega, v = y[:4], y[4:7], y[7:]
    k = [2 * (qx * qz + qw * qy), 2 * (qy * qz - qw * qx), 1 - 2 * (qx * qx + qy * qy)]
    q_dot = [
        -(qx * omega[0] + qy * omega[1] + qz * omega[2]) / 2,
        (qw * omega[0] + qz * omega[1] - qy * omega[2]) / 2,
        (qw * omega[1] + qx * omega[2] - qz * omega[0]) / 2,
        (qw * omega[2] + qy * omega[0] - qx * omega[1]) / 2,
    ]
    spin, k_dot = dot(omega, k), cross(omega, k)

    def omega_dot(torque):
        # I omega_dot = torque - omega x I omega, with I = I1 + (I3 - I1) k k
        push = [t - (I3 - I1) * spin * c for t, c in zip(torque, k_dot, strict=True)]
        along = dot(push, k)
        return [p / I1 + (1 / I3 - 1 / I1) * along * a for p, a in zip(push, k, strict=True)]

    if job["contact"] == "none":
        return q_dot + omega_dot([0, 0, 0]) + [0, 0, -g]
    c = body["centre_offset"]
    a = [c * k[0], c * k[1], c * k[2] - R]
    slip = [p + q for p, q in zip(v, cross(omega, a), strict=True)]
    law, mu = job["friction"]["law"], job["friction"]["mu"]
    ratio = {"none": 0, "coulomb": mu / max(hypot(slip[0], slip[1]), SLOW), "viscous": mu}[law]
    direction = [-ratio * slip[0], -ratio * slip[1], 1]

    def rise(normal):
        """Vertical acceleration of the sphere's centre, which the table keeps at 0."""
        turning = omega_dot([normal * t for t in cross(a, direction)])
        k_ddot = cross(turning, k)[2] + cross(omega, k_dot)[2]
        return normal / m - g + c * k_ddot

    free = rise(0)
    normal = free / (free - rise(1))
    force = [normal * part for part in direction]
    return q_dot + omega_dot(cross(a, force)) + [force[0] / m, force[1] / m, force[2] / m - g]


def step(job, y, h):
    def ahead(rate, by):
        return [p + by * r for p, r in zip(y, rate, strict=True)]

    k1 = rates(job, y)
    k2 = rates(job, ahead(k1, h / 2))
    k3 = rates(job, ahead(k2, h / 2))
    k4 = rates(job, ahead(k3, h))
    return [
        p + h / 6 * (a + 2 * b + 2 * c + d) for p, a, b, c, d in zip(y, k1, k2, k3, k4, strict=True)
    ]


def main():
    job = json.load(sys.stdin)
    if job["friction"]["law"] not in ("none", "coulomb", "viscous"):
        print("no such friction here", file=sys.stderr)
        sys.exit(3)
    start = job["start"]
    y = start["quaternion_wxyz"] + start["angular_velocity"] + start["velocity"]
    print("# engine: Runge and Kutta in Python")
    print("t,qw,qx,qy,qz,wx,wy,wz,vcx,vcy,vcz")
    done = 0
    for t in job["sample_times"]:
        while done < round(t / job["step"]):
            y = step(job, y, job["step"])
            size = sqrt(dot(y[:4], y[:4]))
            y[:4] = [part / size for part in y[:4]]
            done += 1
        print(",".join(map(repr, [t, *y])))


if __name__ == "__main__":
    main()
