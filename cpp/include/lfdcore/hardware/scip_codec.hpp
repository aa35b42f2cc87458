// The words of SCIP 2.0, which the LIDARs of Hokuyo speak (C-42-03320B): sums, replies, parameters, distances.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lfdcore/grid/laser_scan.hpp"

namespace lfdcore {

/// The sum that ends a line of a reply: the lower 6 bits of its bytes' sum, as a character of '0' to 'o'.
char scip_sum(std::string_view text);

/// The number that 1 to 5 characters of 6 bits each encode, the first one highest. Throws DataError for other counts
/// and other characters.
std::uint32_t decode_scip(std::string_view characters);

/// A reply: the command as the device repeats it, its status of two characters, and the lines that follow, each still
/// with its sum.
struct ScipReply {
  std::string_view echo, status;
  std::vector<std::string_view> lines;
};

/// Takes a reply apart, which is given without the two line feeds that end it, and checks its status' sum. The parts
/// are views of `text`. Throws DataError.
ScipReply parse_scip_reply(std::string_view text);

/// Puts bytes, as they come in, together into replies.
class ScipReplies {
 public:
  static constexpr std::size_t longest = 65536;  ///< [bytes] of a reply; what is longer is none, and is dropped

  void add(const std::uint8_t* bytes, std::size_t count);

  /// The next whole reply without the two line feeds that end it; a view that holds until the next add() or clear().
  std::optional<std::string_view> next();

  void clear();

 private:
  std::string text_;
  std::size_t taken_ = 0;     // before it: what next() gave
  std::size_t searched_ = 0;  // before it: no end of a reply after taken_
};

/// "NAME:value;" of each line (of the replies to VV, PP and II): value by name, both in printable ASCII. Throws
/// DataError for a wrong sum or a line that is none.
std::map<std::string, std::string> parse_scip_fields(const ScipReply& reply);

/// What a device says of itself (PP). A step is 2 pi / steps_per_turn, counted counter-clockwise as seen from above.
struct ScipParameters {
  std::string model;                             ///< MODL
  int range_min = 0, range_max = 0;              ///< DMIN, DMAX [mm]
  int steps_per_turn = 0;                        ///< ARES
  int first_step = 0, last_step = 0, front = 0;  ///< AMIN, AMAX, AFRT
  int turns_per_minute = 0;                      ///< SCAN

  std::size_t beams() const { return static_cast<std::size_t>(last_step - first_step + 1); }
  double scan_period() const { return 60.0 / turns_per_minute; }  ///< [s]
};

/// Throws DataError for a wrong sum, a parameter that is missing, and one that cannot be.
ScipParameters parse_scip_parameters(const ScipReply& reply);

/// The command that asks for every scan of all the device's beams, 3 characters a distance, until QT.
std::string measure_command(const ScipParameters& parameters);

/// What the device's clock said, in ms modulo 2^24, in the first line after a status (TM1, MD, GD). Throws DataError.
std::uint32_t parse_scip_time(const ScipReply& reply);

/// The distances and codes of the beams [mm], of `width` characters each (3: MD, GD; 2: MS, GS), from the lines after
/// the time. Throws DataError for a wrong sum, and unless there are `beams` of them.
void parse_scip_distances(const ScipReply& reply, std::size_t width, std::size_t beams,
                          std::vector<std::uint32_t>& distances);

/// A scan in the device's frame (x ahead, z up), as LaserScan has it. `upside_down`: as a device sees that hangs.
///
/// Distances of DMAX and beyond are +inf. Those below DMIN (and below 20: all codes) are NaN, but code 1 of a UTM-30LX,
/// "no object in the range", is +inf.
LaserScan scan_from_scip(const std::vector<std::uint32_t>& distances, const ScipParameters& parameters,
                         bool upside_down);

/// What a status says in the reply to a command, in words.
std::string scip_status_meaning(std::string_view command, std::string_view status);

}  // namespace lfdcore
