// Drives a fuzz target where there is no libFuzzer: PROGRAM [RUNS [SEED]] gives it texts like those that devices send,
// with random damage. The same seed gives the same inputs.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <random>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t bound) { return random() % bound; }

std::string any_part(Random& random) {
  static const char* const parts[] = {"\n",
                                      "\n\n",
                                      "99",
                                      "00",
                                      "MD0000000301000",
                                      "PP",
                                      "TM1",
                                      ":",
                                      ";",
                                      "DMIN:23;",
                                      "DMAX:9999;",
                                      "ARES:1440;",
                                      "AMIN:0;",
                                      "AMAX:3;",
                                      "AFRT:2;",
                                      "SCAN:2400;",
                                      "0000",
                                      "00C00C00C00C",
                                      "MODL:X;",
                                      "o",
                                      "0",
                                      "99999999999",
                                      "-1",
                                      "\xff",
                                      "\0"};
  const std::size_t which = below(random, std::size(parts) + 2);
  if (which < std::size(parts)) return parts[which];
  return std::string(1 + below(random, 70),
                     static_cast<char>(which == std::size(parts) ? '0' + below(random, 64) : random()));
}

// A whole reply to MD or PP that the damage starts from, or nothing.
std::string any_start(Random& random) {
  static const char* const starts[] = {
      "", "MD0000000301000\n99\n0123\n00C00D00E0OK\n\n",
      "PP\n00\nMODL:UTM-30LX;\nDMIN:23;\nDMAX:60000;\nARES:1440;\nAMIN:0;\nAMAX:1080;\nAFRT:540;\nSCAN:2400;\n\n"};
  return starts[below(random, std::size(starts))];
}

std::string any_input(Random& random) {
  std::string text = any_start(random);
  for (std::size_t i = below(random, 30); i > 0; --i) {
    const std::size_t at = below(random, text.size() + 1);
    if (below(random, 3) == 0)
      text.erase(at, below(random, 8));
    else
      text.insert(at, any_part(random));
  }
  return text;
}

}  // namespace

int main(int count, char** arguments) {
  const long runs = count > 1 ? std::atol(arguments[1]) : 100'000;
  const unsigned long long seed = count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 1;
  Random random(seed);
  for (long run = 0; run < runs; ++run) {
    const std::string text = any_input(random);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  }
  std::printf("%ld random inputs of seed %llu\n", runs, seed);
}
