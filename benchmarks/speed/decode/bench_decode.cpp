// Throughput of the decoders, fed in pieces of 4 KiB, with every value of every message used,
// compared with a plain parser that searches, checks and copies into vectors.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/detail/crc32.hpp>
#include <wayfare/decode/mt_raw.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/xbus.hpp>

#include "decode/makers_nodes.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::decode;

using Stream = std::vector<std::uint8_t>;
constexpr std::size_t kPiece = 4096;

template <class T>
void put_le(Stream& out, T value) {
  std::uint8_t bytes[sizeof(T)];
  store_le(value, bytes);
  for (const std::uint8_t byte : bytes) out.push_back(byte);
}
template <class T>
void put_be(Stream& out, T value) {
  std::uint8_t bytes[sizeof(T)];
  store_be(value, bytes);
  for (const std::uint8_t byte : bytes) out.push_back(byte);
}

/// Frames as an AWR1843 sends them: 150 points with side information, range profile, statistics.
Stream ti_stream() {
  Rng rng(1);
  Stream out;
  for (std::uint32_t i = 1; i <= 300; ++i) {
    const std::size_t start = out.size();
    out.insert(out.end(), kTiMagic.begin(), kTiMagic.end());
    for (const std::uint32_t word : {0x03060000U, 0U, 0xA1843U, i, 20'000'000 * i, 150U, 4U, 0U})
      put_le(out, word);
    put_le(out, 1U);
    put_le(out, 150U * 16U);
    for (int k = 0; k < 600; ++k) put_le(out, static_cast<float>(rng.uniform(-8.0, 8.0)));
    put_le(out, 7U);
    put_le(out, 150U * 4U);
    for (int k = 0; k < 300; ++k) put_le(out, static_cast<std::int16_t>(rng.below(800)));
    put_le(out, 2U);
    put_le(out, 512U);
    for (int k = 0; k < 256; ++k) put_le(out, static_cast<std::uint16_t>(rng.below(12000)));
    put_le(out, 6U);
    put_le(out, 24U);
    for (int k = 0; k < 6; ++k) put_le(out, static_cast<std::uint32_t>(rng.below(50000)));
    while ((out.size() - start) % 32 != 0) out.push_back(15);
    store_le(static_cast<std::uint32_t>(out.size() - start), &out[start + 12]);
  }
  return out;
}

/// Frames of 3D people counting, 150 compressed points each, behind the demo's header or, with
/// `checked`, behind one of 48 bytes with a checksum.
Stream people_stream(bool checked) {
  Rng rng(6);
  Stream out;
  for (std::uint32_t i = 1; i <= 300; ++i) {
    const std::size_t start = out.size();
    out.insert(out.end(), kTiMagic.begin(), kTiMagic.end());
    if (checked) {
      for (const std::uint32_t word : {0x03020004U, 0U, 0xA6843U, i, 0U, 11U, 2500U, 900U, 4U, 1U})
        put_le(out, word);
    } else {
      for (const std::uint32_t word : {0x03060000U, 0U, 0xA6843U, i, 20'000'000 * i, 150U, 1U, 0U})
        put_le(out, word);
    }
    const std::uint32_t length = 20 + 150 * 8;
    put_le(out, checked ? 6U : 1020U);
    put_le(out, checked ? length + 8 : length);
    for (const float unit : {0.01F, 0.01F, 0.05F, 0.00025F, 0.04F}) put_le(out, unit);
    for (int k = 0; k < 150 * 4; ++k) put_le(out, static_cast<std::uint16_t>(rng.below(60'000)));
    while ((out.size() - start) % 32 != 0) out.push_back(15);
    store_le(static_cast<std::uint32_t>(out.size() - start), &out[start + 12]);
    if (!checked) continue;
    std::uint32_t sum = 0;
    for (std::size_t k = 0; k < 46; k += 2) sum += load_le<std::uint16_t>(&out[start + k]);
    store_le(static_cast<std::uint16_t>(~((sum >> 16) + (sum & 0xFFFF))), &out[start + 46]);
  }
  return out;
}

/// Messages of an MTi at 100 Hz: counter, time, acceleration, rate, field, quaternion, status.
Stream xbus_stream() {
  Rng rng(2);
  Stream out;
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    Stream data;
    const auto vector = [&](std::uint16_t id, int n) {
      put_be(data, id);
      data.push_back(static_cast<std::uint8_t>(4 * n));
      for (int k = 0; k < n; ++k) put_be(data, static_cast<float>(rng.uniform(-10.0, 10.0)));
    };
    put_be(data, std::uint16_t{0x1020});
    data.push_back(2);
    put_be(data, static_cast<std::uint16_t>(i));
    put_be(data, std::uint16_t{0x1060});
    data.push_back(4);
    put_be(data, 100 * i);
    vector(0x2010, 4);
    vector(0x4020, 3);
    vector(0x8020, 3);
    vector(0xC020, 3);
    put_be(data, std::uint16_t{0xE020});
    data.push_back(4);
    put_be(data, 7U);
    Stream message(data.size() + 7);
    message.resize(write_xbus(0xFF, XbusId::mt_data2, data, message));
    out.insert(out.end(), message.begin(), message.end());
  }
  return out;
}

Stream node_stream() {
  Rng rng(3);
  Stream out;
  for (unsigned i = 0; i < 200'000; ++i) {
    const unsigned angle = i * 76 % (360 * 64);
    out.push_back(static_cast<std::uint8_t>(15 << 2 | (angle < 76 ? 1 : 2)));
    out.push_back(static_cast<std::uint8_t>((angle & 0x7F) << 1 | 1));
    out.push_back(static_cast<std::uint8_t>(angle >> 7));
    put_le(out, static_cast<std::uint16_t>(rng.below(40000)));
  }
  return out;
}

Stream capsule_stream(std::size_t contents) {
  Rng rng(4);
  Stream out;
  for (unsigned i = 0; i < 5000; ++i) {
    Stream capsule(4 + contents);
    for (auto& byte : capsule) byte = static_cast<std::uint8_t>(rng());
    store_le(static_cast<std::uint16_t>(i * 640 % (360 * 64)), &capsule[2]);
    unsigned sum = 0;
    for (std::size_t k = 2; k < capsule.size(); ++k) sum ^= capsule[k];
    capsule[0] = static_cast<std::uint8_t>(0xA0 | (sum & 15));
    capsule[1] = static_cast<std::uint8_t>(0x50 | sum >> 4);
    out.insert(out.end(), capsule.begin(), capsule.end());
  }
  return out;
}

Stream ultra_dense_stream() {
  Rng rng(7);
  Stream out;
  for (unsigned i = 0; i < 5000; ++i) {
    Stream capsule(170);
    for (auto& byte : capsule) byte = static_cast<std::uint8_t>(rng());
    store_le(static_cast<std::uint16_t>(i * 640 % (360 * 64)), &capsule[8]);
    unsigned sum = 0;
    for (std::size_t k = 2; k < capsule.size(); ++k) sum ^= capsule[k];
    capsule[0] = static_cast<std::uint8_t>(0xA0 | (sum & 15));
    capsule[1] = static_cast<std::uint8_t>(0x50 | sum >> 4);
    out.insert(out.end(), capsule.begin(), capsule.end());
  }
  return out;
}

Stream hq_stream() {
  Rng rng(8);
  Stream out;
  for (unsigned i = 0; i < 1000; ++i) {
    Stream capsule(777);
    for (auto& byte : capsule) byte = static_cast<std::uint8_t>(rng());
    capsule[0] = 0xA5;
    capsule.resize(780, 0);
    const std::uint32_t sum = wayfare::decode::detail::crc32(capsule);
    capsule.resize(781);
    store_le(sum, &capsule[777]);
    out.insert(out.end(), capsule.begin(), capsule.end());
  }
  return out;
}

/// Raw readings and temperatures of an MTi.
Stream raw_stream() {
  Rng rng(9);
  Stream out;
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    Stream data = {0xA0, 0x10, 20};
    for (int k = 0; k < 10; ++k) put_be(data, static_cast<std::uint16_t>(rng.below(65'536)));
    data.insert(data.end(), {0xA0, 0x20, 6, 1, 2, 3, 4, 5, 6});
    Stream message(data.size() + 7);
    message.resize(write_xbus(0xFF, XbusId::mt_data2, data, message));
    out.insert(out.end(), message.begin(), message.end());
  }
  return out;
}

/// Feeds the stream in pieces.
template <class Decoder, class Sink>
void run(benchmark::State& state, const Stream& stream, Decoder& decoder, Sink&& sink) {
  for (auto _ : state) {
    for (std::size_t at = 0; at < stream.size(); at += kPiece)
      decoder.feed(Bytes(stream).subspan(at, std::min(kPiece, stream.size() - at)), sink);
  }
  if (decoder.statistics().skipped_bytes != 0) state.SkipWithError("bytes were skipped");
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(stream.size()));
}

void ti_frames(benchmark::State& state, const Stream& stream) {
  const auto decoder = std::make_unique<TiDecoder>();
  float sum = 0.0F;
  run(state, stream, *decoder, [&](const TiFrame& f) {
    for (std::size_t i = 0; i < f.size(); ++i) {
      const TiPoint p = f[i];
      sum += p.x_m + p.y_m + p.z_m + p.doppler_mps + static_cast<float>(p.snr_ddb);
    }
  });
  benchmark::DoNotOptimize(sum);
}

void xbus_messages(benchmark::State& state) {
  const auto decoder = std::make_unique<XbusDecoder>();
  unsigned sum = 0;
  run(state, xbus_stream(), *decoder,
      [&](const XbusMessage& m) { sum += m.data()[m.data().size() - 1]; });
  benchmark::DoNotOptimize(sum);
}

void xbus_samples(benchmark::State& state) {
  const auto decoder = std::make_unique<XbusDecoder>();
  double sum = 0.0;
  run(state, xbus_stream(), *decoder, [&](const XbusMessage& m) {
    const auto s = mt_sample(m.data());
    if (s && s->acceleration_mps2 && s->rate_radps)
      sum += s->acceleration_mps2->x() + s->rate_radps->z();
  });
  benchmark::DoNotOptimize(sum);
}

void xbus_raw(benchmark::State& state) {
  const auto decoder = std::make_unique<XbusDecoder>();
  double sum = 0.0;
  run(state, raw_stream(), *decoder, [&](const XbusMessage& m) {
    const MtRawReadings r = mt_raw_readings(m.data());
    if (r.counts && r.gyro_temperature_c) sum += r.counts->gyroscope[1] + r.gyro_temperature_c->x();
  });
  benchmark::DoNotOptimize(sum);
}

void rplidar(benchmark::State& state, const Stream& stream, RplidarResponse answer) {
  RplidarDecoder decoder{RplidarFraming(answer)};
  RplidarUnpacker unpacker;
  std::uint64_t sum = 0;
  run(state, stream, decoder, [&](const RplidarPacket& packet) {
    unpacker.add(packet, [&](std::span<const RplidarPoint> points) {
      for (const RplidarPoint& p : points) sum += p.angle_q6 + p.distance_q2;
    });
  });
  benchmark::DoNotOptimize(sum);
}

// ---- the plain parsers ----

/// Collects bytes in a vector, parses complete messages, then removes them.
template <class Take>
void plain(benchmark::State& state, const Stream& stream, Take&& take) {
  for (auto _ : state) {
    Stream held;
    for (std::size_t at = 0; at < stream.size(); at += kPiece) {
      held.insert(held.end(), stream.begin() + static_cast<long>(at),
                  stream.begin() + static_cast<long>(std::min(at + kPiece, stream.size())));
      std::size_t used = 0;
      while (const std::size_t n = take(Bytes(held).subspan(used))) used += n;
      held.erase(held.begin(), held.begin() + static_cast<long>(used));
    }
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(stream.size()));
}

void plain_ti(benchmark::State& state) {
  float sum = 0.0F;
  plain(state, ti_stream(), [&](Bytes held) -> std::size_t {
    const auto start = std::search(held.begin(), held.end(), kTiMagic.begin(), kTiMagic.end());
    held = held.subspan(static_cast<std::size_t>(start - held.begin()));
    if (held.size() < 40) return 0;
    const auto total = load_le<std::uint32_t>(&held[12]);
    if (held.size() < total) return 0;
    std::vector<TiPoint> points;
    std::size_t item = 40;
    for (std::uint32_t i = 0; i < load_le<std::uint32_t>(&held[32]); ++i) {
      const auto type = load_le<std::uint32_t>(&held[item]);
      const auto length = load_le<std::uint32_t>(&held[item + 4]);
      const std::uint8_t* p = &held[item + 8];
      for (std::uint32_t k = 0; type == 1 && k < length / 16; ++k, p += 16) {
        TiPoint point;
        std::memcpy(&point.x_m, p, 4);
        std::memcpy(&point.y_m, p + 4, 4);
        std::memcpy(&point.z_m, p + 8, 4);
        std::memcpy(&point.doppler_mps, p + 12, 4);
        points.push_back(point);
      }
      for (std::size_t k = 0; type == 7 && k < length / 4; ++k, p += 4)
        std::memcpy(&points[k].snr_ddb, p, 2);
      item += 8 + length;
    }
    for (const TiPoint& p : points)
      sum += p.x_m + p.y_m + p.z_m + p.doppler_mps + static_cast<float>(p.snr_ddb);
    return total;
  });
  benchmark::DoNotOptimize(sum);
}

void plain_xbus(benchmark::State& state) {
  unsigned last_bytes = 0;
  plain(state, xbus_stream(), [&](Bytes held) -> std::size_t {
    if (held.size() < 5) return 0;
    if (held[0] != 0xFA) return 1;
    const std::size_t total = 5U + held[3];
    if (held.size() < total) return 0;
    std::uint8_t sum = 0;
    for (std::size_t i = 1; i < total; ++i) sum = static_cast<std::uint8_t>(sum + held[i]);
    if (sum != 0) return 1;
    const Stream data(held.begin() + 4, held.begin() + static_cast<long>(total));
    last_bytes += data[data.size() - 2];
    return total;
  });
  benchmark::DoNotOptimize(last_bytes);
}

void plain_nodes(benchmark::State& state) {
  std::uint64_t sum = 0;
  const Stream stream = node_stream();
  for (auto _ : state)
    makers_nodes(stream, [&](const RplidarPoint& p) { sum += p.angle_q6 + p.distance_q2; });
  benchmark::DoNotOptimize(sum);
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(stream.size()));
}

BENCHMARK_CAPTURE(ti_frames, demo, ti_stream())->Name("ti_frames/wayfare");
BENCHMARK_CAPTURE(ti_frames, people, people_stream(false))->Name("ti_people/wayfare");
BENCHMARK_CAPTURE(ti_frames, checked, people_stream(true))->Name("ti_people_48/wayfare");
BENCHMARK(plain_ti)->Name("ti_frames/plain");
BENCHMARK(xbus_messages)->Name("xbus_messages/wayfare");
BENCHMARK(plain_xbus)->Name("xbus_messages/plain");
BENCHMARK(xbus_samples)->Name("xbus_samples/wayfare");
BENCHMARK(xbus_raw)->Name("xbus_raw/wayfare");
BENCHMARK_CAPTURE(rplidar, node, node_stream(), RplidarResponse::node)
    ->Name("rplidar_nodes/wayfare");
BENCHMARK(plain_nodes)->Name("rplidar_nodes/plain");
BENCHMARK_CAPTURE(rplidar, express, capsule_stream(80), RplidarResponse::express)
    ->Name("rplidar_express/wayfare");
BENCHMARK_CAPTURE(rplidar, ultra, capsule_stream(128), RplidarResponse::ultra)
    ->Name("rplidar_ultra/wayfare");
BENCHMARK_CAPTURE(rplidar, dense, capsule_stream(80), RplidarResponse::dense)
    ->Name("rplidar_dense/wayfare");

BENCHMARK_CAPTURE(rplidar, ultra_dense, ultra_dense_stream(), RplidarResponse::ultra_dense)
    ->Name("rplidar_ultra_dense/wayfare");
BENCHMARK_CAPTURE(rplidar, hq, hq_stream(), RplidarResponse::hq)->Name("rplidar_hq/wayfare");

}  // namespace
