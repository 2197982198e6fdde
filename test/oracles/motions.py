"""First contacts in closed form, to fifty digits: of balls, planes and a rod that turns."""

import mpmath

DIGITS = 50


def ball_and_plane(height, way, radius, least):
    """Return when a ball at a height that comes down by ``way`` is ``least`` above the plane."""
    with mpmath.workdps(DIGITS):
        return (mpmath.mpf(height) - mpmath.mpf(radius) - mpmath.mpf(least)) / mpmath.mpf(way)


def two_balls(p, way, radii, least):
    """Return when balls at the distance vector p, which changes by ``way``, are ``least`` apart.

    None if they never are between the times 0 and 1.
    """
    with mpmath.workdps(DIGITS):
        p, way = [mpmath.mpf(x) for x in p], [mpmath.mpf(x) for x in way]
        reach = mpmath.mpf(radii[0]) + mpmath.mpf(radii[1]) + mpmath.mpf(least)
        a = sum(v * v for v in way)
        b = 2 * sum(x * v for x, v in zip(p, way, strict=True))
        c = sum(x * x for x in p) - reach**2
        if c <= 0:
            return mpmath.mpf(0)
        if a == 0 or b * b < 4 * a * c:
            return None
        first = (-b - mpmath.sqrt(b * b - 4 * a * c)) / (2 * a)
        return first if 0 <= first <= 1 else None


def rod_and_ball(angle, bearing, away, radii, least):
    """Return when a rod along x that turns by ``angle`` about z is ``least`` from a ball.

    The ball's centre is ``away`` from the middle of the rod, by a bearing from x, and nearer than
    the end of the rod.
    """
    with mpmath.workdps(DIGITS):
        reach = mpmath.mpf(radii[0]) + mpmath.mpf(radii[1]) + mpmath.mpf(least)
        return (mpmath.mpf(bearing) - mpmath.asin(reach / mpmath.mpf(away))) / mpmath.mpf(angle)
