"""Closed forms of textbook optics that traced rays are compared to."""

import numpy as np


def normal_reflectance(n):
    return ((n - 1.0) / (n + 1.0)) ** 2


def reflectances(n1, n2, incidence):
    """R_s and R_p by Fresnel's sine and tangent laws (Born and Wolf, Principles of Optics, section 1.5)."""
    refraction = np.arcsin(n1 / n2 * np.sin(incidence))
    difference, total = incidence - refraction, incidence + refraction
    return (np.sin(difference) / np.sin(total)) ** 2, (np.tan(difference) / np.tan(total)) ** 2


def slab_reflectance(r):
    """All orders of reflection from a lossless slab whose faces each reflect r."""
    return 2.0 * r / (1.0 + r)


def slab_transmittance(r, tau):
    """All orders of transmission through a slab whose faces reflect r and whose inside passes tau once."""
    return (1.0 - r) ** 2 * tau / (1.0 - (r * tau) ** 2)


def slab_total_reflectance(r, tau):
    """All orders of reflection from an absorbing slab."""
    return r + r * (1.0 - r) ** 2 * tau**2 / (1.0 - (r * tau) ** 2)


def critical_angle(n1, n2):
    return np.arcsin(n2 / n1)


def plate_shift(n, thickness, incidence):
    """Sideways shift of a ray through a plane-parallel plate."""
    cosine = np.cos(incidence)
    return thickness * np.sin(incidence) * (1.0 - cosine / np.sqrt(n**2 - np.sin(incidence) ** 2))


def prism_minimum_deviation(n, apex):
    return 2.0 * np.arcsin(n * np.sin(0.5 * apex)) - apex


def ball_lens_focal_length(n, diameter):
    return n * diameter / (4.0 * (n - 1.0))


def rainbow_incidence(n, order):
    """Incidence of least deviation after `order` internal reflections (Descartes)."""
    return np.arccos(np.sqrt((n**2 - 1.0) / (order * (order + 2))))


def ball_deviation(n, incidence, order):
    """Deviation of a ray that leaves a ball after `order` internal reflections."""
    return 2.0 * (incidence - np.arcsin(np.sin(incidence) / n)) + order * (
        np.pi - 2.0 * np.arcsin(np.sin(incidence) / n)
    )


def concentric_focal_length(radii, indices):
    """Distance from the axis to the paraxial focus of concentric cylinders or spheres.

    `radii` from the outside inwards, `indices` from the surroundings inwards. By the conserved product
    n r sin(i), a ray at height h turns by h (1/n_k - 1/n_{k+1}) / r_k at each surface, and it crosses each twice.
    """
    turn = 0.0
    for radius, before, after in zip(radii, indices[:-1], indices[1:], strict=True):
        turn += 2.0 * (1.0 / before - 1.0 / after) / radius
    return 1.0 / turn
