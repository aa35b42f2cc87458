// Frames between a PC and the Arduino at the joystick (docs/joystick-link.md). Freestanding C++11 without the standard
// library: the firmware includes this very file.
#pragma once

#include <stddef.h>
#include <stdint.h>

namespace lfdcore {
namespace joystick {

/// The first byte of every frame. Frames of another version are not understood.
constexpr uint8_t protocol_version = 1;

/// CRC-16/MCRF4XX: x^16 + x^12 + x^5 + 1, reflected, begun with 0xFFFF. Of "123456789" it is 0x6F91. Sent after the
/// rest with its low byte first, it finds every 1, 2 and 3 wrong bits, and every burst of up to 16 in the order in
/// which a serial line sends them: of each byte, the lowest first.
inline uint16_t crc16(const uint8_t* bytes, size_t count) {
  uint16_t crc = 0xFFFF;
  for (size_t i = 0; i < count; ++i) {
    uint8_t mixed = static_cast<uint8_t>(bytes[i] ^ (crc & 0xFF));
    mixed = static_cast<uint8_t>(mixed ^ (mixed << 4));
    const uint16_t wide = mixed;
    crc = static_cast<uint16_t>(((wide << 8) | (crc >> 8)) ^ (wide >> 4) ^ (wide << 3));
  }
  return crc;
}

/// Writes numbers, little-endian, one after the other.
class Writer {
 public:
  explicit Writer(uint8_t* to) : to_(to) {}
  void u8(uint8_t value) { *to_++ = value; }
  void u16(uint16_t value) {
    u8(static_cast<uint8_t>(value & 0xFF));
    u8(static_cast<uint8_t>(value >> 8));
  }
  void i16(int16_t value) { u16(static_cast<uint16_t>(value)); }
  void u32(uint32_t value) {
    u16(static_cast<uint16_t>(value & 0xFFFF));
    u16(static_cast<uint16_t>(value >> 16));
  }
  void i32(int32_t value) { u32(static_cast<uint32_t>(value)); }

 private:
  uint8_t* to_;
};

/// Reads what a Writer wrote.
class Reader {
 public:
  explicit Reader(const uint8_t* from) : from_(from) {}
  uint8_t u8() { return *from_++; }
  uint16_t u16() {
    const uint16_t low = u8();
    return static_cast<uint16_t>(low | (static_cast<uint16_t>(u8()) << 8));
  }
  int16_t i16() { return static_cast<int16_t>(u16()); }
  uint32_t u32() {
    const uint32_t low = u16();
    return low | (static_cast<uint32_t>(u16()) << 16);
  }
  int32_t i32() { return static_cast<int32_t>(u32()); }

 private:
  const uint8_t* from_;
};

/// Consistent overhead byte stuffing (Cheshire and Baker 1999) of at most 254 bytes: one byte more, none of them 0.
inline size_t cobs_encode(const uint8_t* from, size_t count, uint8_t* to) {
  size_t code_at = 0, written = 1;
  for (size_t i = 0; i < count; ++i) {
    if (from[i] != 0) {
      to[written++] = from[i];
      continue;
    }
    to[code_at] = static_cast<uint8_t>(written - code_at);
    code_at = written++;
  }
  to[code_at] = static_cast<uint8_t>(written - code_at);
  return written;
}

/// The reverse -> how many bytes, 0 for what no encoder writes. `to` holds `count` bytes; it may be `from`.
inline size_t cobs_decode(const uint8_t* from, size_t count, uint8_t* to) {
  size_t read = 0, written = 0;
  while (read < count) {
    const size_t block = from[read];
    if (block == 0 || read + block > count) return 0;
    for (size_t i = 1; i < block; ++i) {
      if (from[read + i] == 0) return 0;
      to[written++] = from[read + i];
    }
    read += block;
    if (read < count) to[written++] = 0;
  }
  return written;
}

/// 1 byte each of version, type and sequence before the payload, 2 of CRC after it.
constexpr size_t header_bytes = 3, crc_bytes = 2;
/// Of any type.
constexpr size_t most_payload = 36;
constexpr size_t most_body = header_bytes + most_payload + crc_bytes;
/// On the wire, with the byte that COBS adds and the 0 that ends each frame.
constexpr size_t most_wire = most_body + 2;

/// What a frame is about. Each type has one direction and one length of payload.
enum class FrameType : uint8_t {
  command = 1,          ///< PC -> chip: what the chair is to do, in answer to a report
  query = 2,            ///< PC -> chip: asks for the identity
  set_calibration = 3,  ///< PC -> chip: to be stored; answered by the identity
  select_profile = 4,   ///< PC -> chip
  report = 16,          ///< chip -> PC, every 10 ms
  identity = 17,        ///< chip -> PC, in answer to a query or a calibration
};

/// Of a type's payload [bytes]; 255 for a type that there is not.
inline uint8_t payload_bytes(uint8_t type) {
  switch (static_cast<FrameType>(type)) {
    case FrameType::command:
      return 8;
    case FrameType::query:
      return 0;
    case FrameType::set_calibration:
      return 32;
    case FrameType::select_profile:
      return 1;
    case FrameType::report:
      return 34;
    case FrameType::identity:
      return 36;
  }
  return 255;
}

struct Frame {
  FrameType type;
  uint8_t sequence;        ///< counted by the sender, of all its frames: gaps are lost frames
  const uint8_t* payload;  ///< payload_bytes(type) of them
};

/// Writes a frame as it goes over the wire, its 0 included -> how many bytes, most_wire at most.
inline size_t encode_frame(FrameType type, uint8_t sequence, const uint8_t* payload, uint8_t* wire) {
  uint8_t body[most_body];
  const size_t bytes = payload_bytes(static_cast<uint8_t>(type));
  body[0] = protocol_version;
  body[1] = static_cast<uint8_t>(type);
  body[2] = sequence;
  for (size_t i = 0; i < bytes; ++i) body[header_bytes + i] = payload[i];
  Writer(body + header_bytes + bytes).u16(crc16(body, header_bytes + bytes));
  const size_t written = cobs_encode(body, header_bytes + bytes + crc_bytes, wire);
  wire[written] = 0;
  return written + 1;
}

enum class Decoded : uint8_t { frame, not_cobs, wrong_length, wrong_crc, wrong_version, unknown_type };

/// Takes a decoded body apart. `frame` is valid for Decoded::frame, and as long as `body` is.
inline Decoded decode_body(const uint8_t* body, size_t count, Frame& frame) {
  if (count < header_bytes + crc_bytes || count > most_body) return Decoded::wrong_length;
  if (crc16(body, count - crc_bytes) != Reader(body + count - crc_bytes).u16()) return Decoded::wrong_crc;
  if (body[0] != protocol_version) return Decoded::wrong_version;
  const uint8_t bytes = payload_bytes(body[1]);
  if (bytes == 255) return Decoded::unknown_type;
  if (count != header_bytes + bytes + crc_bytes) return Decoded::wrong_length;
  frame = {static_cast<FrameType>(body[1]), body[2], body + header_bytes};
  return Decoded::frame;
}

/// Finds frames in a stream that may begin anywhere, and hold anything.
class FrameReader {
 public:
  /// Takes the next byte -> whether a frame, or what was none, ended with it; `outcome` says which. `frame` is valid
  /// until the next byte. Two 0 in a row are nothing.
  bool take(uint8_t byte, Decoded& outcome, Frame& frame) {
    if (byte != 0) {
      if (count_ < sizeof(bytes_)) bytes_[count_] = byte;
      if (count_ <= sizeof(bytes_)) ++count_;  // one more than fits: too long
      return false;
    }
    const size_t count = count_;
    count_ = 0;
    if (count == 0) return false;
    if (count > sizeof(bytes_)) {
      outcome = Decoded::wrong_length;
      return true;
    }
    const size_t body = cobs_decode(bytes_, count, bytes_);
    outcome = body == 0 ? Decoded::not_cobs : decode_body(bytes_, body, frame);
    return true;
  }

 private:
  uint8_t bytes_[most_body + 1];
  size_t count_ = 0;
};

}  // namespace joystick
}  // namespace lfdcore
