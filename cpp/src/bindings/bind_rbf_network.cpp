#include "arrays.hpp"
#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/error.hpp"
#include "lfdcore/estimation/rbf_network.hpp"
#include "lfdcore/estimation/rbf_network_bank.hpp"

namespace lfdcore {
namespace {

using Integers = Contiguous<std::int32_t>;

Integers as_view(const std::vector<std::int32_t>& values, const py::object& owner) {
  Integers array(static_cast<py::ssize_t>(values.size()), values.data(), owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

RbfNetworkBank::Keys copy(const Integers& values) { return {values.data(), values.data() + values.size()}; }

void bind_config(py::module_& m) {
  bind_settings(m, "RbfNetworkConfig",
                "sigma: standard deviation of every Gaussian, in the inputs' units; threshold: stop once "
                "the largest squared residual is below it; max_centres: at most so many (App. C.1).",
                Field("sigma", &RbfNetworkConfig::sigma), Field("threshold", &RbfNetworkConfig::threshold),
                Field("max_centres", &RbfNetworkConfig::max_centres));
}

void bind_network(py::module_& m) {
  py::class_<RbfNetwork>(m, "RbfNetwork",
                         "y = sum_j w_j exp(-|x - m_j|^2 / (2 sigma^2)), clipped to [0, 1]: 0 far from every centre.")
      .def(py::init([](RowMatrix centres, Eigen::VectorXd weights, double sigma) {
             require(centres.rows() == weights.size(),
                     std::to_string(weights.size()) + " weights for " + std::to_string(centres.rows()) + " centres");
             require(centres.allFinite() && weights.allFinite(), "centres and weights must be finite");
             require_positive("sigma", sigma, "");
             return RbfNetwork{std::move(centres), std::move(weights), sigma};
           }),
           py::arg("centres"), py::arg("weights"), py::arg("sigma"))
      .def_readonly("centres", &RbfNetwork::centres, "(M, D)")
      .def_readonly("weights", &RbfNetwork::weights, "(M,)")
      .def_readonly("sigma", &RbfNetwork::sigma)
      .def("predict", &RbfNetwork::predict, py::arg("inputs"), without_gil(),
           "Inputs (N, D) -> (N,) in [0, 1]; an input with NaN gives 0. ValueError for another D.");
  m.def("fit_rbf_network", &fit_rbf_network, py::arg("inputs"), py::arg("targets"), py::arg("config"), without_gil(),
        "Alg. 5 (ERRATA 45): inputs (N, D), targets (N,) -> RbfNetwork. The next centre is the input of the largest "
        "squared residual; weights by least squares. ValueError for no or non-finite data.");
}

void bind_bank(py::module_& m) {
  py::class_<RbfNetworkBank>(m, "RbfNetworkBank",
                             "One-class RBF networks side by side, one a key (Sec. 3.3: one a cell), as flat arrays.")
      .def(py::init([](const Integers& keys, const Integers& offsets, RowMatrix centres, Eigen::VectorXd weights,
                       double sigma) {
             return RbfNetworkBank(copy(keys), copy(offsets), std::move(centres), std::move(weights), sigma);
           }),
           py::arg("keys"), py::arg("offsets"), py::arg("centres"), py::arg("weights"), py::arg("sigma"),
           "Network c: keys[c] (rising), centres[offsets[c]:offsets[c+1]]. ValueError unless they fit together.")
      .def_static(
          "fit",
          [](const RowMatrix& inputs, const Integers& keys, const RbfNetworkConfig& config) {
            const auto key = view(keys);
            py::gil_scoped_release free;
            return RbfNetworkBank::fit(inputs, key, config);
          },
          py::arg("inputs"), py::arg("keys"), py::arg("config"),
          "Inputs (N, D), keys (N,) int -> a network for every key that occurs, all targets 1.")
      .def(
          "predict",
          [](const RbfNetworkBank& bank, const Doubles& shared, const Doubles& own) {
            py::array_t<double> estimates(static_cast<py::ssize_t>(bank.size()));
            const std::span<double> out(estimates.mutable_data(), bank.size());
            const auto common = view(shared), each = view(own);
            py::gil_scoped_release free;
            bank.predict(common, each, out);
            return estimates;
          },
          py::arg("shared"), py::arg("own"),
          "All C networks at once: inputs are `shared` (S,), the same for all, then the network's row of `own` "
          "(C, D - S) -> (C,) in [0, 1]. NaN or inf in `own` gives 0; ValueError for wrong sizes or NaN in `shared`.")
      .def("__len__", &RbfNetworkBank::size)
      .def_property_readonly("dimensions", &RbfNetworkBank::dimensions, "D")
      .def_property_readonly(
          "keys", [](const py::object& self) { return as_view(self.cast<RbfNetworkBank&>().keys(), self); },
          "(C,) int32, a view")
      .def_property_readonly(
          "offsets", [](const py::object& self) { return as_view(self.cast<RbfNetworkBank&>().offsets(), self); },
          "(C + 1,) int32, a view")
      .def_property_readonly("centres", &RbfNetworkBank::centres, py::return_value_policy::reference_internal,
                             "(M, D), a view")
      .def_property_readonly("weights", &RbfNetworkBank::weights, py::return_value_policy::reference_internal,
                             "(M,), a view")
      .def_property_readonly("sigma", &RbfNetworkBank::sigma);
}

}  // namespace

void bind_rbf_network(py::module_& m) {
  bind_config(m);
  bind_network(m);
  bind_bank(m);
}

}  // namespace lfdcore
