// Throughput of the decoders, fed in pieces of 4 KiB, with every value of every message used,
// compared with a plain parser that searches, checks and copies into vectors.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include <wayfare/decode/mt_raw.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/xbus.hpp>

#include "decode/makers_nodes.hpp"
#include "streams.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::decode;

constexpr std::size_t kPiece = 4096;

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
