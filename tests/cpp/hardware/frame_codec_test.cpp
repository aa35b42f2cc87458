// The codec of docs/joystick-link.md. LFDCORE_WIRE_ERRORS and LFDCORE_RANDOM_BYTES say how much chance is run.
#include "lfdcore/hardware/frame_codec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "../count_from.hpp"

namespace lfdcore {
namespace joystick {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Random = std::mt19937_64;

const FrameType types[] = {FrameType::command,        FrameType::query,  FrameType::set_calibration,
                           FrameType::select_profile, FrameType::report, FrameType::identity};

Bytes random_bytes(Random& random, std::size_t count) {
  Bytes bytes(count);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

// Payloads full of 0 too: there COBS has most to do.
Bytes any_payload(Random& random, FrameType type) {
  Bytes bytes = random_bytes(random, payload_bytes(static_cast<std::uint8_t>(type)));
  if (random() % 2 == 0)
    for (std::uint8_t& byte : bytes) byte = random() % 3 == 0 ? byte : 0;
  return bytes;
}

Bytes wire_of(FrameType type, std::uint8_t sequence, const Bytes& payload) {
  Bytes wire(most_wire);
  wire.resize(encode_frame(type, sequence, payload.data(), wire.data()));
  return wire;
}

Bytes body_of(FrameType type, std::uint8_t sequence, const Bytes& payload) {
  const Bytes wire = wire_of(type, sequence, payload);
  Bytes body(most_wire);
  body.resize(cobs_decode(wire.data(), wire.size() - 1, body.data()));
  return body;
}

bool is_frame(const Bytes& body) {
  Frame frame;
  return decode_body(body.data(), body.size(), frame) == Decoded::frame;
}

// How many frames a reader finds in some bytes that are followed by a 0.
struct Found {
  long frames = 0, checked = 0;  // checked: whose CRC was looked at
};

void read_all(FrameReader& reader, const Bytes& bytes, Found& found) {
  Decoded outcome;
  Frame frame;
  for (const std::uint8_t byte : bytes) {
    if (!reader.take(byte, outcome, frame)) continue;
    found.frames += outcome == Decoded::frame;
    found.checked += outcome != Decoded::not_cobs && outcome != Decoded::wrong_length;
  }
}

TEST(FrameCodec, its_crc_has_the_check_value_of_its_variant) {
  const char* text = "123456789";
  EXPECT_EQ(crc16(reinterpret_cast<const std::uint8_t*>(text), 9), 0x6F91);
}

TEST(FrameCodec, stuffing_gives_back_what_it_was_given_and_no_zero) {
  Random random(1);
  for (int n = 0; n < 20000; ++n) {
    Bytes bytes = random_bytes(random, random() % 255);
    for (std::uint8_t& byte : bytes) byte = random() % 4 == 0 ? 0 : byte;
    Bytes stuffed(256), back(256);
    stuffed.resize(cobs_encode(bytes.data(), bytes.size(), stuffed.data()));
    ASSERT_EQ(std::count(stuffed.begin(), stuffed.end(), 0), 0);
    ASSERT_EQ(stuffed.size(), bytes.size() + 1);
    back.resize(cobs_decode(stuffed.data(), stuffed.size(), back.data()));
    ASSERT_EQ(back, bytes);
  }
}

TEST(FrameCodec, a_frame_comes_out_as_it_went_in_also_byte_by_byte_after_noise) {
  Random random(2);
  FrameReader reader;
  for (int n = 0; n < 20000; ++n) {
    Found noise;
    Bytes before = random_bytes(random, random() % 80);
    before.push_back(0);
    read_all(reader, before, noise);
    const FrameType type = types[n % 6];
    const Bytes payload = any_payload(random, type), wire = wire_of(type, static_cast<std::uint8_t>(n), payload);
    ASSERT_LE(wire.size(), most_wire);
    Decoded outcome = Decoded::wrong_crc;
    Frame frame;
    for (std::size_t i = 0; i < wire.size(); ++i) ASSERT_EQ(reader.take(wire[i], outcome, frame), i + 1 == wire.size());
    ASSERT_EQ(outcome, Decoded::frame);
    ASSERT_EQ(frame.type, type);
    ASSERT_EQ(frame.sequence, static_cast<std::uint8_t>(n));
    ASSERT_EQ(Bytes(frame.payload, frame.payload + payload.size()), payload);
  }
}

class EachType : public testing::TestWithParam<FrameType> {};
INSTANTIATE_TEST_SUITE_P(FrameCodec, EachType, testing::ValuesIn(types));

// hazard: Bits flip on the wire | requirement:
// every 1, 2 and 3 wrong bits, and every burst of up to 16, in each type of decoded frame are rejected
// | count: 6 types, all errors
TEST_P(EachType, every_error_of_up_to_three_bits_and_every_burst_of_up_to_sixteen_is_rejected) {
  Random random(3);
  Bytes body = body_of(GetParam(), 7, any_payload(random, GetParam()));
  ASSERT_TRUE(is_frame(body));
  const std::size_t bits = 8 * body.size();
  const auto flip = [&](std::size_t bit) { body[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8)); };
  for (std::size_t a = 0; a < bits; ++a) {
    flip(a);
    ASSERT_FALSE(is_frame(body)) << a;
    for (std::size_t b = a + 1; b < bits; ++b) {
      flip(b);
      ASSERT_FALSE(is_frame(body)) << a << " " << b;
      for (std::size_t c = b + 1; c < bits; ++c) {
        flip(c);
        if (is_frame(body)) FAIL() << a << " " << b << " " << c;
        flip(c);
      }
      flip(b);
    }
    flip(a);
  }
  // In the order in which a serial line sends them: the low bits of a byte first.
  for (std::size_t first = 0; first + 1 < bits; ++first)
    for (unsigned inside = 0; inside < (1u << 15); ++inside) {
      const auto burst = [&] {
        flip(first);
        for (std::size_t k = 0; k < 15 && first + 1 + k < bits; ++k)
          if (inside >> k & 1) flip(first + 1 + k);
      };
      if (inside >> std::min<std::size_t>(15, bits - first - 1) != 0) break;  // the same as one before
      burst();
      if (is_frame(body)) FAIL() << "burst at " << first << ", " << inside;
      burst();
    }
}

TEST_P(EachType, every_wrong_bit_on_the_wire_is_rejected) {
  Random random(4);
  const Bytes next = wire_of(FrameType::query, 0, {});
  for (int n = 0; n < 200; ++n) {
    Bytes wire = wire_of(GetParam(), static_cast<std::uint8_t>(n), any_payload(random, GetParam()));
    for (std::size_t bit = 0; bit + 8 < 8 * wire.size(); ++bit) {  // a 0 that is hit takes the next frame with it
      wire[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
      FrameReader reader;
      Found found;
      read_all(reader, wire, found);
      ASSERT_EQ(found.frames, 0) << bit;
      read_all(reader, next, found);
      ASSERT_EQ(found.frames, 1) << bit;
      wire[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    }
  }
}

TEST(FrameCodec, says_why_a_frame_is_none) {
  Bytes body = body_of(FrameType::query, 1, {});
  Frame frame;
  const auto outcome = [&] {
    Writer(body.data() + body.size() - 2).u16(crc16(body.data(), body.size() - 2));
    return decode_body(body.data(), body.size(), frame);
  };
  EXPECT_EQ(outcome(), Decoded::frame);
  body[0] = protocol_version + 1;
  EXPECT_EQ(outcome(), Decoded::wrong_version);
  body[0] = protocol_version;
  body[1] = 99;
  EXPECT_EQ(outcome(), Decoded::unknown_type);
  body[1] = static_cast<std::uint8_t>(FrameType::command);
  EXPECT_EQ(outcome(), Decoded::wrong_length);
  FrameReader reader;
  Decoded said = Decoded::frame;
  bool ended = false;
  for (int i = 0; i < 10000; ++i) ended = reader.take(1, said, frame) || ended;
  EXPECT_FALSE(ended);
  EXPECT_TRUE(reader.take(0, said, frame));
  EXPECT_EQ(said, Decoded::wrong_length);
}

// Wilson's 95 % interval of a share.
struct Share {
  double value, low, high;
  Share(long hits, long n) : value(static_cast<double>(hits) / static_cast<double>(n)) {
    const double z = 1.96, m = static_cast<double>(n);
    const double middle = (value + z * z / (2 * m)) / (1 + z * z / m);
    const double half = z * std::sqrt(value * (1 - value) / m + z * z / (4 * m * m)) / (1 + z * z / m);
    low = std::max(0.0, middle - half);
    high = middle + half;
  }
};

void expect_no_more_than_chance(const char* name, const Found& found) {
  const Share share(found.frames, std::max(found.checked, 1L));
  std::printf("%s: %ld of %ld frames whose CRC was looked at were taken, %.2g [%.2g, %.2g]; 2^-16 is %.2g\n", name,
              found.frames, found.checked, share.value, share.low, share.high, std::ldexp(1, -16));
  EXPECT_LE(share.low, std::ldexp(1, -16));
}

// hazard: Bits flip on the wire | requirement:
// of frames with 2 or 3 wrong bits or a burst on the wire no more are taken than chance lets through
// | count: 20000 errors, LFDCORE_WIRE_ERRORS
TEST(FrameCodec, of_random_errors_on_the_wire_no_more_are_taken_than_by_chance) {
  const long errors = test::count_from("LFDCORE_WIRE_ERRORS", 20000);
  Random random(5);
  Found two, three, burst;
  for (long n = 0; n < errors; ++n) {
    const FrameType type = types[random() % 6];
    Bytes wire = wire_of(type, static_cast<std::uint8_t>(n), any_payload(random, type));
    const std::size_t bits = 8 * (wire.size() - 1);
    const auto flip = [&](std::size_t bit) { wire[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8)); };
    const std::size_t first = random() % bits;
    flip(first);
    const std::size_t second = (first + 1 + random() % (bits - 1)) % bits;
    if (n % 3 < 2) flip(second);
    for (std::size_t third = first; n % 3 == 1 && (third == first || third == second);)
      if ((third = random() % bits) != first && third != second) flip(third);
    if (n % 3 == 2)
      for (std::size_t k = 1; k < 16 && first + k < bits; ++k)
        if (random() % 2 == 0) flip(first + k);
    FrameReader reader;
    read_all(reader, wire, n % 3 == 0 ? two : n % 3 == 1 ? three : burst);
  }
  expect_no_more_than_chance("2 wrong bits on the wire", two);
  expect_no_more_than_chance("3 wrong bits on the wire", three);
  expect_no_more_than_chance("a burst on the wire", burst);
}

// hazard: Garbage comes in | requirement: no more of it is taken than chance lets through
// | count: 2000000 random bytes, LFDCORE_RANDOM_BYTES
TEST(FrameCodec, of_random_bytes_no_more_are_taken_than_by_chance) {
  const long count = test::count_from("LFDCORE_RANDOM_BYTES", 2000000);
  Random random(6);
  FrameReader reader;
  Found found;
  for (long n = 0; n < count; n += 4096) {
    Bytes bytes = random_bytes(random, 4096);
    for (std::uint8_t& byte : bytes) byte = random() % 24 == 0 ? 0 : byte;  // ends often: else all is too long
    read_all(reader, bytes, found);
  }
  expect_no_more_than_chance("random bytes", found);
}

}  // namespace
}  // namespace joystick
}  // namespace lfdcore
