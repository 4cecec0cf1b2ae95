#include "step_length_options.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

#include "support/json_object.hpp"

namespace wayfare::examples {
namespace {

using Json = nlohmann::json;

/// In the order of the alternatives of StepLength.
const std::vector<std::string> kNames = {"kim", "constant", "weinberg", "frequency"};

bool is_positive(double x) { return x > 0.0 && std::isfinite(x); }

/// The model of a word in kNames with its own factor, or `factor` if that is above zero.
StepLength named(const std::string& name, double factor, double height_m) {
  StepLength model = KimStep{};
  if (name == "constant") model = ConstantStep{};
  if (name == "weinberg") model = WeinbergStep{};
  if (name == "frequency") model = HeightFrequencyStep{0.3139, height_m};
  if (factor > 0.0) std::visit([&](auto& m) { m.factor = factor; }, model.models());
  return model;
}

/// A positive number at `key`.
std::optional<double> positive(const Json& json, const char* key) {
  if (!json.contains(key) || !json[key].is_number()) return std::nullopt;
  const auto value = json[key].get<double>();
  return is_positive(value) ? std::optional(value) : std::nullopt;
}

}  // namespace

void StepLengthOptions::add_options(CommandLine& app) {
  app.add_option("--length", length, "step length model").one_of(kNames).show_default();
  app.add_option("--factor", factor, "the model's factor, from a walk of known length").positive();
  app.add_positive("--height", height_m, "of the walker, metres (with --length frequency)");
  app.add_file("--calibration", calibration,
               "step length model and factor, as pedestrian --known-length writes them")
      .excludes("--length")
      .excludes("--factor")
      .excludes("--height");
}

Result<StepLength> StepLengthOptions::model() const {
  if (!calibration.empty()) return read_step_calibration(calibration);
  return named(length, factor, height_m);
}

std::string name_of(const StepLength& model) { return kNames[model.models().index()]; }

double factor_of(const StepLength& model) {
  return std::visit([](const auto& m) { return m.factor; }, model.models());
}

Result<StepLength> calibrated_to(const StepLength& model, std::span<const Step> steps,
                                 double length_m) {
  if (!is_positive(length_m))
    return Error{ErrorCode::invalid, "the known length must be a positive number of metres"};
  double sum_m = 0.0;
  for (const Step& step : steps) sum_m += model(step);
  if (!is_positive(sum_m)) return Error{ErrorCode::degenerate, "the steps have no length"};
  return calibrated(model, steps, length_m);
}

Result<StepLength> read_step_calibration(const std::string& path) {
  const auto content = io::read_file(path);
  if (!content) return content.error();
  const auto parsed = parse_json_object<Json>(content->bytes, path);
  if (!parsed) return parsed.error();
  const Json& json = *parsed;
  const auto error = [&](const std::string& what) { return Error{ErrorCode::parse, what, path}; };
  const std::string name =
      json.contains("length") && json["length"].is_string() ? json["length"] : Json("");
  if (std::find(kNames.begin(), kNames.end(), name) == kNames.end())
    return error("needs 'length': kim, constant, weinberg or frequency");
  const auto factor = positive(json, "factor"), height_m = positive(json, "height_m");
  if (!factor) return error("needs 'factor', a positive number");
  if (name == "frequency" && !height_m) return error("needs 'height_m', a positive number");
  return named(name, *factor, height_m.value_or(0.0));
}

Result<void> write_step_calibration(const std::string& path, const StepLength& model,
                                    double known_length_m, std::size_t steps,
                                    const io::WriteOptions& options) {
  Json json{{"length", name_of(model)},
            {"factor", factor_of(model)},
            {"known_length_m", known_length_m},
            {"steps", steps}};
  if (const auto* m = std::get_if<HeightFrequencyStep>(&model.models()))
    json["height_m"] = m->height_m;
  return io::write_file(path, json.dump(2) + "\n", options);
}

}  // namespace wayfare::examples
