#include "option_fields.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include <wayfare/io/text_file.hpp>

namespace wayfare::examples {

using Json = nlohmann::ordered_json;

OptionField option_field(const char* name, double& value) {
  return {name, [&](double v) { value = v; }, [&] { return value; }};
}
OptionField option_field(const char* name, int& value) {
  return {name, [&](double v) { value = static_cast<int>(v); },
          [&] { return static_cast<double>(value); }, true};
}
OptionField option_field(const char* name, Angle& value) {
  return {name, [&](double v) { value = Angle::degrees(v); },
          [&] { return std::round(value.degrees() * 1e6) / 1e6; }};
}

Result<void> read_option_fields(const std::string& path, const std::vector<OptionField>& known) {
  const auto file = io::read_file(path);
  if (!file) return file.error();
  const Json json = Json::parse(file->bytes, nullptr, false, true);
  const auto error = [&](const std::string& what) { return Error{ErrorCode::parse, what, path}; };
  if (!json.is_object()) return error("expected a JSON object of options");
  for (const auto& [key, value] : json.items()) {
    const auto match =
        std::find_if(known.begin(), known.end(),
                     [&, name = key](const OptionField& f) { return f.name == name; });
    if (match == known.end())
      return error("unknown option '" + key + "'; --print-config lists all options");
    const double number = value.is_number() ? value.get<double>() : std::nan("");
    if (!(number > 0.0 && number < 1e6))
      return error("option '" + key + "' must be a positive number");
    match->set(number);
  }
  return {};
}

std::string option_fields_text(const std::vector<OptionField>& fields) {
  Json json;
  for (const OptionField& f : fields)
    json[f.name] = f.whole ? Json(static_cast<int>(f.get())) : Json(f.get());
  return json.dump(2) + "\n";
}

}  // namespace wayfare::examples
