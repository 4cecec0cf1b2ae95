// Any capture of a device to a table: bytes as they came from its port, plain or gzip.

#include <cstdio>
#include <map>
#include <string>

#include <wayfare/decode/ti_config.hpp>
#include <wayfare/io/text_file.hpp>

#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "tables.hpp"

namespace {

using namespace wayfare;

struct Arguments {
  std::string device, capture, out, config;
  bool csv = false, force = false, quiet = false;
  examples::RplidarTableOptions rplidar;
  decode::MtLegacyLayout layout;
};

const std::map<std::string, decode::RplidarResponse> kAnswers = {
    {"descriptor", decode::RplidarResponse::none},
    {"node", decode::RplidarResponse::node},
    {"express", decode::RplidarResponse::express},
    {"ultra", decode::RplidarResponse::ultra},
    {"dense", decode::RplidarResponse::dense}};

void describe(examples::CommandLine& app, Arguments& a) {
  app.add_option("device", a.device, "ti (AWR1843 and its family), rplidar or xsens")
      .required()
      .one_of({"ti", "awr1843", "rplidar", "xsens"});
  app.add_option("file", a.capture, "the capture, plain or gzip").required();
  app.add_flag("--csv", a.csv, "comma-separated values, the only form there is so far");
  app.add_option("--out", a.out, "file to write; left out: standard output");
  app.add_flag("--force", a.force, "replace the file of an earlier run");
  app.add_flag("--quiet", a.quiet, "no summary");
  app.add_option("--config", a.config, "ti: chirp configuration (.cfg), for speeds before SDK 3");
  app.add_choice("--inside", a.rplidar.inside, kAnswers,
                 "rplidar: what the capture begins in the middle of");
  app.add_option("--baud", a.rplidar.baud, "rplidar: rate of the line, which times follow from")
      .range(1200.0, 1e8)
      .show_default();
  app.add_option("--sample-us", a.rplidar.sample_us,
                 "rplidar: time of one sample; left out: what the capture says, else 500 or 250")
      .range(1.0, 1e5);
  app.add_option("--output-mode", a.layout.mode, "xsens: of MTData messages, as set on the device");
  app.add_option("--output-settings", a.layout.settings, "xsens: likewise");
}

Result<std::optional<double>> doppler_step(const Arguments& a) {
  if (a.config.empty()) return std::optional<double>();
  const auto text = io::read_file(a.config);
  if (!text) return text.error();
  const auto config = decode::parse_ti_config(text->bytes, a.config);
  if (!config) return config.error();
  return std::optional(decode::limits_of(*config).speed_step_mps);
}

Result<examples::Table> table_of(const Arguments& a, decode::Bytes capture) {
  if (a.device == "rplidar") return examples::rplidar_table(capture, a.rplidar);
  if (a.device == "xsens") return examples::xsens_table(capture, a.layout);
  const auto step = doppler_step(a);
  if (!step) return step.error();
  return examples::ti_table(capture, *step);
}

void print_summary(const examples::Table& table) {
  const decode::DecoderStatistics& s = table.statistics;
  std::fprintf(stderr, "%s\n", table.contents.c_str());
  std::fprintf(
      stderr, "%llu bytes, %llu of them in no frame, %llu wrong checksums, %llu malformed\n",
      static_cast<unsigned long long>(s.bytes), static_cast<unsigned long long>(s.skipped_bytes),
      static_cast<unsigned long long>(s.checksum_failures),
      static_cast<unsigned long long>(s.malformed));
}

Result<void> run(const Arguments& a) {
  const auto content = io::read_file(a.capture);
  if (!content) return content.error();
  if (content->damage) std::fprintf(stderr, "skipped: %s\n", content->damage->to_string().c_str());
  const auto* begin = reinterpret_cast<const std::uint8_t*>(content->bytes.data());
  const auto table = table_of(a, {begin, content->bytes.size()});
  if (!table) return table.error();
  if (!a.quiet) print_summary(*table);
  if (table->statistics.frames == 0)
    return Error{ErrorCode::parse, "holds no frame of this device", a.capture};
  if (!a.out.empty())
    return io::write_file(a.out, table->csv,
                          {a.force ? io::Existing::replace : io::Existing::refuse});
  if (std::fwrite(table->csv.data(), 1, table->csv.size(), stdout) != table->csv.size() ||
      std::fflush(stdout) != 0)
    return Error{ErrorCode::io, "could not be written", "standard output"};
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Decodes a capture of a device's port to a table, one line a measurement, the first line\n"
      "naming columns and units. What was decoded and what was not is said on standard error.");
  Arguments arguments;
  describe(app, arguments);
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("decode", run(arguments));
}
