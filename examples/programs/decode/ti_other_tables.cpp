#include <algorithm>
#include <cmath>

#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_items.hpp>
#include <wayfare/decode/ti_tracking.hpp>
#include <wayfare/io/text_file.hpp>

#include "tables.hpp"

namespace wayfare::examples {

namespace {

using decode::TiFrame;

constexpr std::string_view kFrameNames =
    "frame,sensor_t_s,subframe,points,targets,presence,version,platform,processing_us,transmit_us,"
    "frame_margin_us,chirp_margin_us,active_load_percent,idle_load_percent,temperature_valid,"
    "temperature_t_ms,rx0_c,rx1_c,rx2_c,rx3_c,tx0_c,tx1_c,tx2_c,pm_c,dig0_c,dig1_c";
constexpr std::string_view kTargetNames =
    "frame,sensor_t_s,target,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps,ax_mps2,ay_mps2,az_mps2,gain,"
    "confidence";

std::string_view names_of(TiTable table) {
  switch (table) {
    case TiTable::profiles:
      return "frame,sensor_t_s,bin,range_profile_db,noise_profile_db,linear_profile";
    case TiTable::doppler_map:
      return "frame,sensor_t_s,range_and_doppler_bin,level_db";
    case TiTable::azimuth_map:
      return "frame,sensor_t_s,range_bin_and_antenna,imaginary,real";
    case TiTable::targets:
      return kTargetNames;
    default:
      return kFrameNames;
  }
}

void add_statistics(const TiFrame& frame, Csv& csv) {
  if (const auto s = frame.statistics()) {
    csv.field(s->processing_us).field(s->transmit_us).field(s->frame_margin_us);
    csv.field(s->chirp_margin_us).field(s->active_load_percent).field(s->idle_load_percent);
  } else {
    csv.empty(6);
  }
  if (const auto t = frame.temperature()) {
    csv.field(t->valid ? 1 : 0).field(t->time_ms);
    for (const std::int16_t celsius : t->celsius) csv.field(celsius);
  } else {
    csv.empty(12);
  }
}

/// Writes the rows of one frame; `begin` starts a row.
template <class Begin>
void add_rows(const TiFrame& frame, TiTable table, Csv& csv, Begin begin) {
  const auto add = [&csv](const auto& numbers, std::size_t i, auto convert) {
    i < numbers.size() ? csv.field(convert(numbers[i])) : csv.empty();
  };
  if (table == TiTable::frames) {
    begin().field(frame.header().subframe).field(frame.size()).field(ti_targets(frame).size());
    const auto presence = decode::ti_presence(frame);
    presence ? csv.field(*presence ? 1 : 0) : csv.empty();
    csv.field(frame.header().version).field(frame.header().platform);
    add_statistics(frame, csv);
  } else if (table == TiTable::profiles) {
    const auto range = ti_range_profile(frame), noise = ti_noise_profile(frame);
    const auto linear = ti_linear_profile(frame);
    const std::size_t n = std::max({range.size(), noise.size(), linear.size()});
    for (std::size_t i = 0; i < n; ++i) {
      begin().field(i);
      add(range, i, decode::ti_level_db);
      add(noise, i, decode::ti_level_db);
      add(linear, i, [](std::uint32_t level) { return level; });
    }
  } else if (table == TiTable::doppler_map) {
    const auto map = ti_range_doppler_map(frame);
    for (std::size_t i = 0; i < map.size(); ++i)
      begin().field(i).field(decode::ti_level_db(map[i]));
  } else if (table == TiTable::azimuth_map) {
    const auto map = ti_azimuth_map(frame);
    for (std::size_t i = 0; i + 1 < map.size(); i += 2)
      begin().field(i / 2).field(map[i]).field(map[i + 1]);
  } else {
    const decode::TiTargets targets = ti_targets(frame);
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const decode::TiTarget t = targets[i];
      begin().field(t.id);
      for (const auto* vector : {&t.position_m, &t.velocity_mps, &t.acceleration_mps2})
        for (const float value : *vector) csv.field(value);
      for (const float value : {t.gain, t.confidence})
        std::isnan(value) ? csv.empty() : csv.field(value);
    }
  }
}

}  // namespace

Table ti_other_table(decode::Bytes capture, TiTable table) {
  Csv csv(names_of(table));
  decode::TiClock clock;
  std::size_t rows = 0;
  const auto decoder = std::make_unique<decode::TiDecoder>();
  const auto take = [&](const TiFrame& frame) {
    const std::string time = frame.header().has_clock()
                                 ? io::format_nanoseconds(clock.at(frame.header()).nanoseconds())
                                 : std::string();
    add_rows(frame, table, csv, [&]() -> Csv& {
      ++rows;
      return csv.row().field(frame.header().frame_number).field(time);
    });
  };
  decoder->feed(capture, take);
  decoder->finish(take);
  return {
      std::move(csv).take(), decoder->statistics(),
      std::to_string(decoder->statistics().frames) + " frames, " + std::to_string(rows) + " rows",
      to_string(decoder->framing().refusal())};
}

}  // namespace wayfare::examples
