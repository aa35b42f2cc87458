// Arrays that Python gives, as the core wants them.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "common.hpp"
#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

/// Row-major; NumPy converts and copies what is not.
template <class Number>
using Contiguous = py::array_t<Number, py::array::c_style | py::array::forcecast>;
using Doubles = Contiguous<double>;

/// Whatever NumPy makes an array of.
class ArrayLike : public py::object {
  static bool anything(py::handle) { return true; }

 public:
  PYBIND11_OBJECT_DEFAULT(ArrayLike, py::object, anything)
};

/// TypeError that names what holds no real numbers: NumPy would parse text and cut complex numbers.
template <class Number>
Contiguous<Number> real_numbers(const std::string& name, const ArrayLike& given) {
  const py::array array(given);
  if (std::string("biuf").find(array.dtype().kind()) != std::string::npos) return Contiguous<Number>(array);
  throw py::type_error(name + " is of dtype " + py::str(py::object(array.dtype())).cast<std::string>() +
                       ", must be of real numbers");
}

/// All numbers of an array, which must outlive the view.
template <class Number>
std::span<const Number> view(const Contiguous<Number>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

/// One series as (T, D): a (T,) array is one dimension.
inline RowMatrix series(const Doubles& array) {
  if (array.ndim() != 1 && array.ndim() != 2)
    throw py::value_error("a series has " + std::to_string(array.ndim()) + " axes, must be (T,) or (T, D)");
  const auto columns = array.ndim() == 2 ? array.shape(1) : 1;
  return Eigen::Map<const RowMatrix>(array.data(), array.shape(0), columns);
}

}  // namespace lfdcore

template <>
struct pybind11::detail::handle_type_name<lfdcore::ArrayLike> {
  static constexpr auto name = const_name("numpy.typing.ArrayLike");
};
