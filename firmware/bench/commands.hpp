// The commands of the bench: one line in, one line out.
#pragma once

#include <string>

#include "bench.hpp"

namespace bench {

extern const char* const command_help;

/// Carries out a command -> its answer: "ok", "error WHY", or JSON. `run`, `send`, `usb` and `trace` belong to the
/// caller.
std::string carry_out(Bench& bench, const std::string& line);

/// Words of a line, and numbers read from them. Throws std::invalid_argument, saying what is wrong.
class Words {
 public:
  explicit Words(const std::string& line);
  std::size_t size() const { return words_.size(); }
  const std::string& word(std::size_t index) const { return words_[index]; }
  double number(std::size_t index, const char* name, double least, double most) const;
  /// Which of two words it is.
  bool choice(std::size_t index, const char* no, const char* yes) const;
  /// Exactly this many, with the command itself.
  void expect(std::size_t count, const char* usage) const;

 private:
  std::vector<std::string> words_;
};

}  // namespace bench
