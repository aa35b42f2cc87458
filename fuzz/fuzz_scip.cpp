// Any bytes from a LIDAR: the codec and the clock take them or refuse them with DataError, and nothing else happens.
#include <algorithm>
#include <cmath>
#include <string>

#include "lfdcore/error.hpp"
#include "lfdcore/hardware/scip_clock.hpp"
#include "lfdcore/hardware/scip_codec.hpp"
#include "require_true.hpp"

namespace {

using namespace lfdcore;

template <typename Work>
void allow_refusal(const Work& work) {
  try {
    work();
  } catch (const DataError&) {
    // the outcome for what is no SCIP
  }
}

void check_ranges(const std::vector<std::uint32_t>& distances, const ScipParameters& said) {
  for (const bool upside_down : {false, true}) {
    const LaserScan scan = scan_from_scip(distances, said, upside_down);
    validate(scan);
    require_true(scan.ranges.size() == said.beams(), "a range for each beam");
    for (const float range : scan.ranges)
      require_true(!std::isfinite(range) || (range >= scan.range_min && range < scan.range_max), "a range that can be");
  }
}

void check_scan(const ScipReply& reply) {
  static const ScipParameters known{"UTM-30LX", 23, 60000, 1440, 0, 3, 540, 2400};
  std::vector<std::uint32_t> distances;
  parse_scip_distances(reply, 3, known.beams(), distances);
  check_ranges(distances, known);
}

void check_parameters(const ScipReply& reply) {
  const ScipParameters said = parse_scip_parameters(reply);
  require_true(measure_command(said).size() == 15, "a command as SCIP has them");
  std::vector<std::uint32_t> distances(said.beams());
  for (std::size_t i = 0; i < distances.size(); ++i) distances[i] = static_cast<std::uint32_t>(i * i) % (1u << 18);
  check_ranges(distances, said);
}

void check_time(const ScipReply& reply) {
  ScipClock clock;
  clock.exchange(parse_scip_time(reply), 1.0, 1.1);
  if (const auto stamp = clock.host_time(parse_scip_time(reply), 1.2))
    require_true(*stamp <= 1.2, "a stamp before it came");
}

void check_reply(std::string_view text) {
  allow_refusal([&] {
    const ScipReply reply = parse_scip_reply(text);
    require_true(!scip_status_meaning(reply.echo, reply.status).empty(), "every status means something");
    for (const auto part : {check_time, check_scan, check_parameters}) allow_refusal([&] { part(reply); });
  });
}

void check(const std::string& stream, std::size_t piece) {
  ScipReplies replies;
  for (std::size_t i = 0; i < stream.size(); i += piece) {
    const std::string part = stream.substr(i, piece);
    replies.add(reinterpret_cast<const std::uint8_t*>(part.data()), part.size());
    while (const auto text = replies.next()) check_reply(*text);
  }
}

// The same lines with right sums: what comes behind the check of the sums is tried, too.
std::string summed(const std::string& stream) {
  std::string all;
  for (std::size_t begin = 0; begin < stream.size();) {
    const std::size_t end = std::min(stream.find('\n', begin), stream.size());
    const std::string line = stream.substr(begin, end - begin);
    all += line.empty() ? "\n" : line + scip_sum(line) + "\n";
    begin = end + 1;
  }
  return all;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string stream(data, data + size);
  const std::size_t piece = size == 0 ? 1 : 1 + data[0] % 64;
  check(stream, piece);
  check(summed(stream), piece);
  return 0;
}
