#include "lfdcore/hardware/scip_codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

using Distances = std::vector<std::uint32_t>;

std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

void add(ScipReplies& replies, const std::string& text) {
  replies.add(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
}

std::string summed(const std::string& line) { return line + scip_sum(line) + "\n"; }

std::string encoded(std::uint32_t value, int characters) {
  std::string text;
  for (int shift = 6 * (characters - 1); shift >= 0; shift -= 6) text += static_cast<char>('0' + (value >> shift) % 64);
  return text;
}

// A reply to MD without its end.
std::string scan_reply(std::uint32_t ticks, const Distances& distances) {
  std::string data, text = "MD0000108001000\n99b\n" + summed(encoded(ticks, 4));
  for (const std::uint32_t distance : distances) data += encoded(distance, 3);
  for (std::size_t i = 0; i < data.size(); i += 64) text += summed(data.substr(i, 64));
  text.pop_back();
  return text;
}

ScipParameters utm_30lx() { return {"UTM-30LX", 23, 60000, 1440, 0, 1080, 540, 2400}; }

// As the specification prints it.
const std::string urg_04lx =
    "PP\n00P\nMODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N\nDMIN:20;4\nDMAX:5600;_\nARES:1024;\\\nAMIN:44;7\nAMAX:725;o\n"
    "AFRT:384;6\nSCAN:600;e";

TEST(ScipCodec, sums_as_the_printed_replies_do) {
  EXPECT_EQ(scip_sum("00"), 'P');
  EXPECT_EQ(scip_sum("99"), 'b');
  EXPECT_EQ(scip_sum("SCAN:600"), 'e');
}

TEST(ScipCodec, decodes_the_numbers_that_the_specification_prints) {
  EXPECT_EQ(decode_scip("CB"), 1234u);
  EXPECT_EQ(decode_scip("1Dh"), 5432u);
  EXPECT_EQ(decode_scip("m2@0"), 16000000u);
}

TEST(ScipCodec, decodes_every_number_of_2_3_and_4_characters) {
  for (std::uint32_t value = 0; value < 1u << 12; ++value) ASSERT_EQ(decode_scip(encoded(value, 2)), value);
  for (std::uint32_t value = 0; value < 1u << 18; ++value) ASSERT_EQ(decode_scip(encoded(value, 3)), value);
  for (std::uint32_t value = 0; value < 1u << 24; value += 97) ASSERT_EQ(decode_scip(encoded(value, 4)), value);
}

TEST(ScipCodec, refuses_characters_that_encode_nothing) {
  for (const char* text : {"0/0", "0p0",
                           "0\xff"
                           "0",
                           "", "000000"})
    EXPECT_NE(error_of([&] { decode_scip(text); }), "no error") << text;
}

TEST(ScipCodec, puts_replies_together_however_they_are_cut) {
  const std::string text = "VV\n00P\nPROT:SCIP 2.0;N\n\nQT\n00P\n\n" + scan_reply(7, {100, 200}) + "\n\n";
  for (std::size_t piece = 1; piece <= text.size(); ++piece) {
    ScipReplies replies;
    std::vector<std::string> got;
    for (std::size_t i = 0; i < text.size(); i += piece) {
      add(replies, text.substr(i, piece));
      while (const auto reply = replies.next()) got.emplace_back(*reply);
    }
    ASSERT_EQ(got, (std::vector<std::string>{"VV\n00P\nPROT:SCIP 2.0;N", "QT\n00P", scan_reply(7, {100, 200})}));
  }
}

TEST(ScipCodec, drops_what_never_ends_and_hears_what_comes_after) {
  ScipReplies replies;
  for (std::size_t i = 0; i < 3 * ScipReplies::longest; i += 1000) {
    add(replies, std::string(1000, 'x'));
    ASSERT_FALSE(replies.next());
  }
  add(replies, "\n\nQT\n00P\n\n");
  std::string last;
  while (const auto reply = replies.next()) last = *reply;
  EXPECT_EQ(last, "QT\n00P");
}

TEST(ScipCodec, reads_the_parameters_that_the_specification_prints) {
  const ScipParameters said = parse_scip_parameters(parse_scip_reply(urg_04lx));
  EXPECT_EQ(said.model, "URG-04LX(Hokuyo Automatic Co.,Ltd.)");
  EXPECT_EQ(said.range_min, 20);
  EXPECT_EQ(said.range_max, 5600);
  EXPECT_EQ(said.steps_per_turn, 1024);
  EXPECT_EQ(said.front, 384);
  EXPECT_EQ(said.beams(), 682u);
  EXPECT_DOUBLE_EQ(said.scan_period(), 0.1);
  EXPECT_EQ(measure_command(said), "MD0044072501000");
}

TEST(ScipCodec, refuses_parameters_that_are_missing_or_cannot_be) {
  const auto changed = [](const std::string& line, const std::string& other) {
    std::string text = urg_04lx;
    text.replace(text.find(line), line.size() + 2, other.empty() ? other : other + ";" + scip_sum(other));
    return error_of([&] { parse_scip_parameters(parse_scip_reply(text)); });
  };
  EXPECT_EQ(changed("DMIN:20", "DMIN:20"), "no error");
  EXPECT_NE(changed("SCAN:600", "SCAN:0").find("its SCAN is '0', must be 1 to 60000"), std::string::npos);
  EXPECT_NE(changed("AMAX:725", "AMAX:44").find("must be 45 to"), std::string::npos);
  EXPECT_NE(changed("AMAX:725", "AMAX:99999").find("must be 45 to 1067"), std::string::npos);
  EXPECT_NE(changed("DMAX:5600", "DMAX:5600m"), "no error");
  EXPECT_NE(changed("ARES:1024", "ARES:"), "no error");
  EXPECT_NE(changed("AFRT:384", "AFRO:384").find("does not say its AFRT"), std::string::npos);
}

TEST(ScipCodec, returns_the_distances_of_random_scans_bit_for_bit) {
  std::mt19937 random(1);
  Distances got;
  for (int scan = 0; scan < 300; ++scan) {
    Distances distances(1 + random() % 1500);
    for (auto& distance : distances) distance = random() % (1u << 18);
    const std::uint32_t ticks = random() % (1u << 24);
    const std::string text = scan_reply(ticks, distances);
    const ScipReply reply = parse_scip_reply(text);
    EXPECT_EQ(reply.status, "99");
    EXPECT_EQ(parse_scip_time(reply), ticks);
    parse_scip_distances(reply, 3, distances.size(), got);
    ASSERT_EQ(got, distances);
  }
}

TEST(ScipCodec, notices_every_single_character_that_changed) {
  const Distances distances{1000, 2000, 3000, 60000, 5, 4095};
  const std::string text = scan_reply(123456, distances);
  const std::size_t begin = text.find('\n') + 1;  // the echo has no sum; it is compared
  for (std::size_t i = begin; i < text.size(); ++i)
    for (const int change : {1, 2, 4, 8, 16, 32}) {
      std::string damaged = text;
      damaged[i] = static_cast<char>(damaged[i] ^ change);
      Distances got;
      EXPECT_NE(error_of([&] {
                  const ScipReply reply = parse_scip_reply(damaged);
                  parse_scip_time(reply);
                  parse_scip_distances(reply, 3, distances.size(), got);
                }),
                "no error")
          << i << " " << change;
    }
}

TEST(ScipCodec, refuses_a_scan_that_was_cut_or_has_a_line_too_few) {
  const Distances distances(1081, 1234);
  const std::string text = scan_reply(0, distances);
  Distances got;
  const auto error = [&](const std::string& cut) {
    return error_of([&] { parse_scip_distances(parse_scip_reply(cut), 3, distances.size(), got); });
  };
  EXPECT_EQ(error(text), "no error");
  for (std::size_t length = 20; length < text.size(); ++length) ASSERT_NE(error(text.substr(0, length)), "no error");
  std::string short_by_a_line = text;
  short_by_a_line.erase(text.find('\n', 40) + 1, 66);
  EXPECT_NE(error(short_by_a_line), "no error");
}

TEST(ScipCodec, puts_the_front_at_0_rad_and_counts_counter_clockwise) {
  const LaserScan scan = scan_from_scip(Distances(1081, 1000), utm_30lx(), false);
  EXPECT_DOUBLE_EQ(scan.angle(540), 0.0);
  EXPECT_DOUBLE_EQ(scan.angle(0), -0.75 * pi);
  EXPECT_DOUBLE_EQ(scan.angle(900), pi / 2);
  EXPECT_FLOAT_EQ(static_cast<float>(scan.range_max), 60.0f);
}

TEST(ScipCodec, mirrors_the_scan_of_a_device_that_hangs) {
  const ScipParameters urg = parse_scip_parameters(parse_scip_reply(urg_04lx));
  Distances distances(urg.beams());
  for (std::size_t i = 0; i < distances.size(); ++i) distances[i] = static_cast<std::uint32_t>(1000 + i);
  const LaserScan upright = scan_from_scip(distances, urg, false), hanging = scan_from_scip(distances, urg, true);
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const std::size_t mirrored = distances.size() - 1 - i;
    ASSERT_EQ(hanging.ranges[mirrored], upright.ranges[i]);
    ASSERT_NEAR(hanging.angle(mirrored), -upright.angle(i), 1e-12);
  }
}

TEST(ScipCodec, says_of_codes_that_nothing_was_measured_and_of_what_is_too_far_that_nothing_is_there) {
  const Distances distances{0, 1, 5, 19, 20, 22, 23, 59999, 60000, 65533};
  const LaserScan utm = scan_from_scip(distances, utm_30lx(), false);
  EXPECT_TRUE(std::isnan(utm.ranges[0]));
  EXPECT_EQ(utm.ranges[1], INFINITY) << "of this model: no object in the range";
  for (const int code : {2, 3, 4, 5}) EXPECT_TRUE(std::isnan(utm.ranges[code]));
  EXPECT_EQ(utm.ranges[6], 0.023f);
  EXPECT_GE(utm.ranges[6], utm.range_min) << "DMIN itself was measured";
  EXPECT_EQ(utm.ranges[7], 59.999f);
  EXPECT_EQ(utm.ranges[8], INFINITY);
  EXPECT_EQ(utm.ranges[9], INFINITY);
  const LaserScan other = scan_from_scip(distances, {"URG-04LX", 0, 5600, 1024, 44, 725, 384, 600}, false);
  for (const int code : {0, 1, 2, 3}) EXPECT_TRUE(std::isnan(other.ranges[code])) << "whatever DMIN says";
  EXPECT_EQ(other.ranges[4], 0.020f);
}

TEST(ScipCodec, says_what_a_status_means_for_its_command) {
  EXPECT_EQ(scip_status_meaning("BM", "01"), "its laser is broken: switch it off and on, else repair it");
  EXPECT_EQ(scip_status_meaning("MD0000108001000", "10"), "its laser is off");
  EXPECT_EQ(scip_status_meaning("GD0000108001", "04"), "the last step is beyond its range");
  EXPECT_EQ(scip_status_meaning("QT", "0E"), "it does not know the command");
  EXPECT_NE(scip_status_meaning("MD", "55").find("broken"), std::string::npos);
  EXPECT_NE(scip_status_meaning("MD", "zz"), "");
}

}  // namespace
}  // namespace lfdcore
