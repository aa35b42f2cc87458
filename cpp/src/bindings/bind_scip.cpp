#include <algorithm>

#include "common.hpp"
#include "lfdcore/hardware/scip_lidar.hpp"

namespace lfdcore {
namespace {

// A lidar that is forgotten ends its thread, which takes a moment, without holding up the others.
struct ClosedWithoutGil {
  void operator()(ScipLidar* lidar) const {
    const py::gil_scoped_release released;
    delete lidar;
  }
};

// In short waits, between which Python looks whether the user wants to interrupt it.
std::optional<TimedScan> wait_newer(const ScipLidar& lidar, std::uint64_t sequence, double patience) {
  constexpr double at_once = 0.1;
  for (;; patience -= at_once) {
    {
      const py::gil_scoped_release released;
      if (auto scan = lidar.wait_newer(sequence, std::min(patience, at_once))) return scan;
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!(patience > at_once)) return std::nullopt;
  }
}

void bind_scip_lidar(py::module_& m) {
  py::class_<TimedScan>(m, "TimedScan", "A scan, when it was taken, and its number.")
      .def_readonly("scan", &TimedScan::scan, "LaserScan")
      .def_readonly("stamp", &TimedScan::stamp,
                    "when the scanner's mirror began its turn, by the clock of time.monotonic() [s]")
      .def_readonly("sequence", &TimedScan::sequence, "1 for the first scan that was received");
  py::class_<ScipStatistics>(m, "ScipStatistics", "What a ScipLidar has received.")
      .def_readonly("scans", &ScipStatistics::scans, "received whole")
      .def_readonly("damaged", &ScipStatistics::damaged,
                    "replies with a wrong sum or a wrong length, and what was no reply")
      .def_readonly("lost", &ScipStatistics::lost,
                    "scans that the device's clock says are missing between those received")
      .def_readonly("reconnects", &ScipStatistics::reconnects, "times that it measured anew after it was lost");
  py::class_<ScipLidar, std::unique_ptr<ScipLidar, ClosedWithoutGil>>(
      m, "ScipLidar",
      "A LIDAR that speaks SCIP 2.0 (Hokuyo UTM-30LX, URG-04LX and their kin), read by a thread of its own from its "
      "construction to close().\n\n"
      "address: a serial port (/dev/...), or host or host:port in the network (port 10940 unless given). A serial port "
      "is tried at `baud`, then at 115200, 19200, 57600 and 500000. upside_down: mounted hanging, so that its scans "
      "are "
      "mirrored.\n\n"
      "Raises DeviceError unless it measures: absent, taken, no SCIP device, broken; ValueError for an address or a "
      "rate "
      "that cannot be. A device that is lost later is no error: fault() says what is wrong, newest() grows old, and "
      "the "
      "thread tries until it measures again.")
      .def(py::init([](const std::string& address, int baud, bool upside_down) {
             return new ScipLidar(address, {baud, upside_down});
           }),
           py::arg("address"), py::kw_only(), py::arg("baud") = ScipConfig{}.baud, py::arg("upside_down") = false,
           without_gil())
      .def("close", &ScipLidar::close, without_gil(),
           "Switches the laser off and ends the thread, within about a second. The last scan stays.")
      .def("newest", &ScipLidar::newest, "The newest scan, at once; None before the first. Compare its stamp with now.")
      .def("wait_newer", &wait_newer, py::arg("sequence"), py::arg("patience"),
           "Waits for a scan with a higher sequence number, `patience` [s] at the longest -> TimedScan or None.")
      .def("statistics", &ScipLidar::statistics, "ScipStatistics until now")
      .def("fault", &ScipLidar::fault, "What is wrong and what to do; empty while it measures.")
      .def("model", &ScipLidar::model, "As the device calls itself.")
      .def("scan_period", &ScipLidar::scan_period, "[s]");
}

}  // namespace

void bind_scip(py::module_& m) { bind_scip_lidar(m); }

}  // namespace lfdcore
