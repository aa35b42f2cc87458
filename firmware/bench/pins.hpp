// What is at the digital pins of port D: contacts to ground and encoders; and the enable line at PB0.
#pragma once

#include <array>
#include <optional>

#include "chip.hpp"

namespace bench {

enum class Level { low, high, open };

/// Pins 2 to 7 of port D. An open one is high where the program has switched its pull-up on, else low: the worse of
/// what it may read.
class InputPins {
 public:
  explicit InputPins(Chip& chip);

  void set(unsigned pin, Level level);
  bool high(unsigned pin) const;

 private:
  void renew();

  Chip& chip_;
  std::array<Level, 8> levels_;
  std::array<avr_irq_t*, 8> irqs_;
};

/// A quadrature encoder. Positive edges: A rises before B.
class Encoder {
 public:
  Encoder(Chip& chip, InputPins& pins, unsigned pin_a, unsigned pin_b);

  /// Edges per second from now on; the part of an edge that was turned already counts.
  void set_rate(double rate);
  /// Edges made: forward less backward.
  long long edges() const { return edges_; }

 private:
  double position(Cycles when) const;
  void plan();
  void step();

  Chip& chip_;
  InputPins& pins_;
  unsigned pin_a_, pin_b_;
  Alarm edge_;
  long long edges_ = 0;
  double rate_ = 0, since_position_ = 0.5;  // [edges/s], [edges]; between edges at first
  Cycles since_ = 0;
};

/// A contact to ground.
class Contact {
 public:
  Contact(InputPins& pins, unsigned pin, bool closed);

  void set_closed(bool closed);
  void set_broken(bool broken);  ///< its wire

 private:
  void renew();

  InputPins& pins_;
  unsigned pin_;
  bool closed_, broken_ = false;
};

/// PB0, pulled down outside the chip.
class EnableLine {
 public:
  EnableLine(Chip& chip, std::function<void(Cycles)> tell);

  bool high() const { return high_; }
  Cycles changed() const { return changed_; }

 private:
  void renew();

  Chip& chip_;
  std::function<void(Cycles)> tell_;
  bool high_ = false;
  Cycles changed_ = 0;
};

}  // namespace bench
