#include "common.hpp"
#include "lfdcore/primitives/orientation.hpp"

namespace lfdcore {

void bind_orientation(py::module_& m) {
  m.def("continuous_quaternions", &continuous_quaternions, py::arg("quaternions"),
        "(T, 4) x y z w -> the same rotations of length 1, the first with w >= 0, each on its predecessor's side "
        "(ERRATA 44). Steps of half a turn are ambiguous. ValueError for a length that is not within [1e-9, 1e9].");
  m.def("imaginary_parts", &imaginary_parts, py::arg("quaternions"), py::arg("reference"),
        "(T, 4), (4,) -> (T, 3): imaginary parts of conj(reference) q with w >= 0, that is axis * sin(angle / 2) in "
        "the reference's frame. ValueError, naming sample and angle, where a series, followed without jumps from its "
        "first sample, turns beyond pi from the reference: take mean_orientation of it.");
  m.def("quaternions_from_imaginary", &quaternions_from_imaginary, py::arg("parts"), py::arg("reference"),
        "Inverse of imaginary_parts: (T, 3), (4,) -> (T, 4) of length 1, w = sqrt(max(0, 1 - |v|^2)) (ERRATA 44): "
        "parts longer than 1 count as half a turn about their axis. ValueError for what is not finite.");
  m.def("geodesic_angle", &geodesic_angle, py::arg("a"), py::arg("b"),
        "(T, 4), (T, 4) -> (T,) angles in [0, pi] [rad] between rows. ValueError for other shapes and zero lengths.");
  m.def("mean_orientation", &mean_orientation, py::arg("quaternions"),
        "(T, 4) -> (4,) with w >= 0: the rotation with the least sum of squared chordal distances (largest "
        "eigenvector of sum q q'). ValueError for no rows and where no mean stands out.");
}

}  // namespace lfdcore
