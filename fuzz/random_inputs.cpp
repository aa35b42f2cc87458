// Drives a fuzz target where there is no libFuzzer, with the same flags: -max_total_time=SECONDS -seed=N -dict=FILE.
// Inputs are random bytes and, with a dictionary, its entries with random damage. The same seed gives the same inputs.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Random = std::mt19937_64;
using Clock = std::chrono::steady_clock;

std::size_t below(Random& random, std::size_t bound) { return random() % bound; }

char hexadecimal(const std::string& digits) { return static_cast<char>(std::strtoul(digits.c_str(), nullptr, 16)); }

// What stands between the first and the last quotation mark of a line; \xNN is a byte.
std::string entry_of(const std::string& line) {
  const std::size_t first = line.find('"'), last = line.rfind('"');
  std::string entry;
  for (std::size_t i = first + 1; i < last; ++i) {
    const bool escaped = line.compare(i, 2, "\\x") == 0;
    entry += escaped ? hexadecimal(line.substr(i + 2, 2)) : line[i];
    if (escaped) i += 3;
  }
  return entry;
}

std::vector<std::string> dictionary(const std::string& file) {
  std::ifstream lines(file);
  if (!lines) {
    std::fprintf(stderr, "cannot read the dictionary %s\n", file.c_str());
    std::exit(2);
  }
  std::vector<std::string> entries;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with('"')) entries.push_back(entry_of(line));
  return entries;
}

std::string any_bytes(Random& random) {
  std::string bytes(1 + below(random, 70), static_cast<char>('0' + below(random, 64)));
  if (below(random, 2) == 0)
    for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

std::string any_part(Random& random, const std::vector<std::string>& entries) {
  const std::size_t which = below(random, entries.size() + 2);
  return which < entries.size() ? entries[which] : any_bytes(random);
}

std::string any_input(Random& random, const std::vector<std::string>& entries) {
  std::string text = below(random, 3) == 0 ? "" : any_part(random, entries);
  for (std::size_t i = below(random, 30); i > 0; --i) {
    const std::size_t at = below(random, text.size() + 1);
    if (below(random, 3) == 0)
      text.erase(at, below(random, 8));
    else
      text.insert(at, any_part(random, entries));
  }
  return text;
}

struct Options {
  double seconds = 10;
  unsigned long long seed = 1;
  std::vector<std::string> entries;

  void take(const std::string& flag) {
    const std::size_t equals = flag.find('=');
    const std::string name = flag.substr(0, equals), value = equals == flag.npos ? "" : flag.substr(equals + 1);
    if (name == "-max_total_time") seconds = std::atof(value.c_str());
    if (name == "-seed") seed = std::strtoull(value.c_str(), nullptr, 10);
    if (name == "-dict") entries = dictionary(value);
  }
};

}  // namespace

int main(int count, char** arguments) {
  Options options;
  for (int i = 1; i < count; ++i) options.take(arguments[i]);
  Random random(options.seed);
  long runs = 0;
  for (const auto begin = Clock::now();
       std::chrono::duration<double>(Clock::now() - begin).count() < options.seconds;) {
    const std::string text = any_input(random, options.entries);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    ++runs;
  }
  std::printf("%s: %ld random inputs of seed %llu\n", arguments[0], runs, options.seed);
}
