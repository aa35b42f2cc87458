#include "lfdcore/hardware/scip_codec.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr std::size_t block = 64;           // characters of data in a line before its sum
constexpr std::uint32_t highest_code = 19;  // distances up to it are codes, whatever DMIN says

bool is_printable(char c) { return c >= ' ' && c <= '~'; }

std::string printable(std::string_view text) {
  std::string readable(text);
  std::replace_if(readable.begin(), readable.end(), [](char c) { return !is_printable(c); }, '?');
  return readable;
}

// What came in, fit for a message.
std::string shown(std::string_view text) {
  return "'" + printable(text.substr(0, 40)) + (text.size() > 40 ? "...'" : "'");
}

// The line without its sum, which is checked.
std::string_view without_sum(std::string_view line) {
  if (line.size() < 2) throw DataError("SCIP: the line " + shown(line) + " is too short for data and a sum");
  const std::string_view data = line.substr(0, line.size() - 1);
  if (scip_sum(data) != line.back()) throw DataError("SCIP: the line " + shown(line) + " has a wrong sum");
  return data;
}

std::pair<std::string, std::string> parse_field(std::string_view line) {
  const std::size_t colon = line.find(':'), end = line.size() < 2 ? 0 : line.size() - 2;
  if (end == 0 || line[end] != ';' || colon > end)
    throw DataError("SCIP: the line " + shown(line) + " should be NAME:value; and a sum");
  // The documents differ on whether the semicolon counts.
  if (const char sum = line.back(); sum != scip_sum(line.substr(0, end)) && sum != scip_sum(line.substr(0, end + 1)))
    throw DataError("SCIP: the line " + shown(line) + " has a wrong sum");
  return {printable(line.substr(0, colon)), printable(line.substr(colon + 1, end - colon - 1))};
}

int number(const std::map<std::string, std::string>& fields, const std::string& name, int low, int high) {
  const auto found = fields.find(name);
  if (found == fields.end()) throw DataError("SCIP: the device does not say its " + name);
  const std::string& text = found->second;
  const char* begin = text.data() + std::min(text.find_first_not_of(' '), text.size());
  int value = 0;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < low || value > high)
    throw DataError("SCIP: the device says that its " + name + " is " + shown(text) + ", must be " +
                    std::to_string(low) + " to " + std::to_string(high));
  return value;
}

std::string four_digits(int step) {
  const std::string digits = std::to_string(step);
  return std::string(4 - std::min<std::size_t>(digits.size(), 4), '0') + digits;
}

float range_of(std::uint32_t distance, const ScipParameters& parameters, bool tells_emptiness) {
  if (distance >= static_cast<std::uint32_t>(parameters.range_max)) return std::numeric_limits<float>::infinity();
  if (distance == 1 && tells_emptiness) return std::numeric_limits<float>::infinity();
  const bool measured = distance > highest_code && distance >= static_cast<std::uint32_t>(parameters.range_min);
  return measured ? static_cast<float>(distance / 1e3) : std::numeric_limits<float>::quiet_NaN();
}

std::string meaning_for_all(std::string_view status) {
  if (status == "00") return "accepted";
  if (status == "99") return "data";
  if (status == "98") return "it measures again, after a check of its laser";
  if (status == "0A") return "it cannot make the reply";
  if (status == "0B") return "its buffer is full, or the command was repeated";
  if (status == "0C" || status == "0F") return "the command has too few parameters";
  if (status == "0D" || status == "0E") return "it does not know the command";
  if (status == "0G" || status == "0H") return "the command's string is too long or has letters that it may not have";
  if (status == "0I") return "its firmware is being updated: switch it off and on";
  if (status >= "21" && status <= "49") return "it has stopped to check an error of its own";
  if (status >= "50" && status <= "97") return "its laser or its motor is broken: switch it off and on, else repair it";
  return "a status that SCIP 2.0 does not have";
}

// Where the same status means something else in each command.
std::string_view meaning_for_one(std::string_view command, std::string_view status) {
  static constexpr std::string_view table[][3] = {
      {"BM", "01", "its laser is broken: switch it off and on, else repair it"},
      {"BM", "02", "its laser is on already"},
      {"TM", "01", "it knows no such control code"},
      {"TM", "02", "it is in time adjustment already"},
      {"TM", "03", "it is not in time adjustment"},
      {"TM", "04", "it tells its time in time adjustment only"},
      {"M", "01", "the first step is no number"},
      {"M", "02", "the last step is no number"},
      {"M", "03", "the cluster is no number"},
      {"M", "04", "the last step is beyond its range"},
      {"M", "05", "the last step is before the first"},
      {"M", "06", "the scan interval is no number"},
      {"M", "07", "the number of scans is no number"},
      {"M", "10", "its laser is off"},
      {"G", "01", "the first step is no number"},
      {"G", "02", "the last step is no number"},
      {"G", "03", "the cluster is no number"},
      {"G", "04", "the last step is beyond its range"},
      {"G", "05", "the last step is before the first"},
      {"G", "10", "its laser is off"},
  };
  for (const auto& [start, code, meaning] : table)
    if (command.starts_with(start) && status == code) return meaning;
  return {};
}

}  // namespace

char scip_sum(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum += static_cast<unsigned char>(c);
  return static_cast<char>('0' + (sum & 0x3f));
}

std::uint32_t decode_scip(std::string_view characters) {
  if (characters.empty() || characters.size() > 5)
    throw DataError("SCIP: a number has 1 to 5 characters, not " + std::to_string(characters.size()));
  std::uint32_t value = 0;
  for (const char c : characters) {
    if (c < '0' || c > 'o') throw DataError("SCIP: " + shown(characters) + " is no number");
    value = value << 6 | static_cast<std::uint32_t>(c - '0');
  }
  return value;
}

ScipReply parse_scip_reply(std::string_view text) {
  ScipReply reply;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    reply.lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  if (reply.lines.size() < 2 || reply.lines[1].size() != 3)
    throw DataError("SCIP: " + shown(text) + " should be an echo, and a status of 2 characters and a sum");
  reply.echo = reply.lines[0];
  reply.status = without_sum(reply.lines[1]);
  if (!is_printable(reply.status[0]) || !is_printable(reply.status[1]))
    throw DataError("SCIP: the status " + shown(reply.status) + " is none");
  reply.lines.erase(reply.lines.begin(), reply.lines.begin() + 2);
  return reply;
}

void ScipReplies::add(const std::uint8_t* bytes, std::size_t count) {
  text_.erase(0, taken_);
  searched_ -= taken_;
  taken_ = 0;
  text_.append(bytes, bytes + count);
}

std::optional<std::string_view> ScipReplies::next() {
  while (taken_ < text_.size() && text_[taken_] == '\n') ++taken_;  // a reply begins with its echo
  const std::size_t end = text_.find("\n\n", std::max(searched_, taken_));
  if (end == std::string::npos) {
    searched_ = std::max(taken_, text_.size() - std::min<std::size_t>(text_.size(), 1));
    if (text_.size() - taken_ > longest) clear();
    return std::nullopt;
  }
  const std::string_view reply = std::string_view(text_).substr(taken_, end - taken_);
  taken_ = searched_ = end + 2;
  return reply;
}

void ScipReplies::clear() {
  text_.clear();
  taken_ = searched_ = 0;
}

std::map<std::string, std::string> parse_scip_fields(const ScipReply& reply) {
  std::map<std::string, std::string> fields;
  for (const std::string_view line : reply.lines) fields.insert(parse_field(line));
  return fields;
}

ScipParameters parse_scip_parameters(const ScipReply& reply) {
  const auto fields = parse_scip_fields(reply);
  const auto model = fields.find("MODL");
  ScipParameters parameters;
  parameters.model = model == fields.end() ? "" : model->second;
  parameters.range_min = number(fields, "DMIN", 0, 1'000'000);
  parameters.range_max = number(fields, "DMAX", parameters.range_min + 1, 1'000'000);
  parameters.steps_per_turn = number(fields, "ARES", 2, 100'000);
  parameters.first_step = number(fields, "AMIN", 0, 9998);  // as many digits as the commands have
  const int last = std::min(9999, parameters.first_step + parameters.steps_per_turn - 1);
  parameters.last_step = number(fields, "AMAX", parameters.first_step + 1, last);
  parameters.front = number(fields, "AFRT", 0, 9999);
  parameters.turns_per_minute = number(fields, "SCAN", 1, 60'000);
  return parameters;
}

std::string measure_command(const ScipParameters& parameters) {
  const std::string every_scan_without_end = "01000";  // cluster of 1, none left out, no number
  return "MD" + four_digits(parameters.first_step) + four_digits(parameters.last_step) + every_scan_without_end;
}

std::uint32_t parse_scip_time(const ScipReply& reply) {
  if (reply.lines.empty() || reply.lines[0].size() != 5) throw DataError("SCIP: a reply without a time");
  return decode_scip(without_sum(reply.lines[0]));
}

void parse_scip_distances(const ScipReply& reply, std::size_t width, std::size_t beams,
                          std::vector<std::uint32_t>& distances) {
  std::string data;
  data.reserve(width * beams);
  for (std::size_t i = 1; i < reply.lines.size(); ++i) {
    const std::string_view line = without_sum(reply.lines[i]);
    if (line.size() > block || (line.size() < block && i + 1 < reply.lines.size()))
      throw DataError("SCIP: a line of " + std::to_string(line.size()) + " characters amid a scan, should be 64");
    data += line;
  }
  if (data.size() != width * beams)
    throw DataError("SCIP: a scan of " + std::to_string(data.size()) + " characters, should be " +
                    std::to_string(width * beams));
  distances.resize(beams);
  for (std::size_t i = 0; i < beams; ++i) distances[i] = decode_scip(std::string_view(data).substr(i * width, width));
}

LaserScan scan_from_scip(const std::vector<std::uint32_t>& distances, const ScipParameters& parameters,
                         bool upside_down) {
  const bool tells_emptiness = parameters.model.starts_with("UTM-30LX");
  LaserScan scan;
  scan.ranges.reserve(distances.size());
  for (const std::uint32_t distance : distances) scan.ranges.push_back(range_of(distance, parameters, tells_emptiness));
  if (upside_down) std::reverse(scan.ranges.begin(), scan.ranges.end());
  scan.angle_increment = 2 * pi / parameters.steps_per_turn;
  const int first = upside_down ? parameters.front - parameters.last_step : parameters.first_step - parameters.front;
  scan.angle_min = first * scan.angle_increment;
  // As the ranges are rounded, so that DMIN itself is not below range_min.
  scan.range_min = static_cast<float>(parameters.range_min / 1e3);
  scan.range_max = static_cast<float>(parameters.range_max / 1e3);
  return scan;
}

std::string scip_status_meaning(std::string_view command, std::string_view status) {
  const std::string_view one = meaning_for_one(command, status);
  return one.empty() ? meaning_for_all(status) : std::string(one);
}

}  // namespace lfdcore
