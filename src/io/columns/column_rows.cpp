#include "io/columns/column_rows.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "io/columns/column_units.hpp"
#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kWeek_s = 604800;

/// Whole numbers separated by `separator`: "2025/07/08".
template <std::size_t kCount>
bool whole_numbers(std::string_view token, char separator, std::array<int, kCount>& values) {
  for (std::size_t i = 0; i < kCount; ++i) {
    const std::size_t end = i + 1 < kCount ? token.find(separator) : token.size();
    if (end == token.npos || !text::to_number(token.substr(0, end), values[i])) return false;
    token.remove_prefix(std::min(token.size(), end + 1));
  }
  return true;
}

/// A decimal number of 10^-decimals seconds, exact.
std::optional<std::int64_t> decimal_ns(std::string_view token, int decimals) {
  if (decimals == 0) return parse_nanoseconds(token);
  if (token.find_first_of("eE") != token.npos) return std::nullopt;
  return parse_nanoseconds(std::string(token) + "e-" + std::to_string(decimals));
}

/// Seconds from 1970-01-01 to midnight of "2025/07/08" or "2025-07-08".
std::optional<std::int64_t> date_seconds(std::string_view token) {
  std::array<int, 3> d{};
  if (!whole_numbers(token, '/', d) && !whole_numbers(token, '-', d)) return std::nullopt;
  if (d[0] < 1900 || d[0] > 2100 || d[1] < 1 || d[2] < 1) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(d[0]),
                                         std::chrono::month(static_cast<unsigned>(d[1])),
                                         std::chrono::day(static_cast<unsigned>(d[2]))};
  if (!date.ok()) return std::nullopt;
  return std::int64_t{86400} * std::chrono::sys_days(date).time_since_epoch().count();
}

/// Nanoseconds of "19:34:18.499".
std::optional<std::int64_t> clock_ns(std::string_view token) {
  const std::size_t last = token.rfind(':');
  std::array<int, 2> hm{};
  if (last == token.npos || !whole_numbers(token.substr(0, last), ':', hm)) return std::nullopt;
  const std::optional<std::int64_t> s = parse_nanoseconds(token.substr(last + 1));
  if (!s || *s < 0 || *s >= 61 * kSecond_ns || hm[0] < 0 || hm[0] > 23 || hm[1] < 0 || hm[1] > 59)
    return std::nullopt;
  return (hm[0] * 3600 + hm[1] * 60) * kSecond_ns + *s;
}

/// The line without a leading comment character.
std::string_view uncommented(std::string_view line) {
  line = text::trimmed(line);
  while (!line.empty() && (line.front() == '#' || line.front() == '%')) line.remove_prefix(1);
  return text::trimmed(line);
}

bool is_comment(std::string_view line) {
  const std::string_view l = text::trimmed(line);
  return l.empty() || l.front() == '#' || l.front() == '%';
}

bool names_a_time(std::string_view field) {
  const std::string_view stem = split_name(field).stem;
  return field == "week" || field == "clock" || field == "utc_clock" ||
         ((stem == "t" || stem == "tow" || stem == "utc" || stem == "unixgps") &&
          find_unit(split_name(field).unit, Dimension::time) != nullptr);
}

}  // namespace

void split_fields(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  if (line.find_first_of(",;") == line.npos) {
    text::Tokens tokens(line);
    for (std::string_view t = tokens.next(); !t.empty(); t = tokens.next()) fields.push_back(t);
    return;
  }
  for (std::size_t end = 0; end != line.npos; line.remove_prefix(std::min(line.size(), end + 1))) {
    end = line.find_first_of(",;");
    fields.push_back(text::trimmed(line.substr(0, end)));
    if (end == line.npos) break;
  }
  if (fields.back().empty()) fields.pop_back();
}

Result<ColumnRows> ColumnRows::open(std::string_view text, const std::string& source,
                                    const ColumnFormat& format, std::span<const Quantity> wanted,
                                    std::size_t required) {
  ColumnRows rows;
  rows.text_ = text;
  rows.source_ = source;
  rows.leap_seconds_ = format.leap_seconds;
  for (const Quantity& quantity : wanted) rows.slots_.push_back({-1, 1.0, quantity});
  if (auto named = rows.name_columns(format); !named) return named.error();
  if (auto present = rows.require(0, required); !present) return present.error();
  return rows;
}

/// The names by the choices, "-" for the other columns. The first line is one of headings unless it
/// begins with a number.
Result<std::vector<std::string>> ColumnRows::chosen_names(const ColumnFormat& format) {
  text::Lines lines(text_);
  std::vector<std::string_view> fields;
  for (std::string_view line; fields.empty() && lines.next(line);)
    if (lines.number() > format.skip_lines) split_fields(uncommented(line), fields);
  const auto unquoted = [](std::string_view field) {
    if (field.size() > 1 && field.front() == '"' && field.back() == '"')
      field = field.substr(1, field.size() - 2);
    return text::trimmed(field);
  };
  for (const std::string_view field : fields) headings_.emplace_back(unquoted(field));
  if (!format.columns.empty()) headings_ = format.columns;
  const bool begins = !fields.empty() && !fields.front().empty();
  const bool heading = begins && fields.front().find_first_of("0123456789+-.") != 0;
  if (heading) first_line_ = lines.number();
  std::vector<std::string> names(headings_.size(), "-");
  for (const ColumnChoice& choice : format.choices) {
    std::size_t number = 0;
    const auto named = std::find(headings_.begin(), headings_.end(), choice.column);
    if (named != headings_.end() && (heading || !format.columns.empty())) {
      number = static_cast<std::size_t>(named - headings_.begin()) + 1;
    } else if (!text::to_number(choice.column, number) || number < 1 || number > names.size()) {
      return Error{ErrorCode::parse,
                   "has no column '" + text::printable(choice.column) + "' for " + choice.name +
                       "; it has " + std::to_string(names.size()) + " columns" +
                       (heading ? ", the first is '" + text::printable(headings_.front()) + "'"
                                : " and no line of headings"),
                   source_, first_line_};
    }
    names[number - 1] = choice.name;
  }
  if (!heading && format.columns.empty()) headings_.assign(names.size(), {});
  return names;
}

Result<void> ColumnRows::name_columns(const ColumnFormat& format) {
  std::vector<std::string> names = format.columns;
  first_line_ = format.skip_lines;
  if (!format.choices.empty()) {
    auto chosen = chosen_names(format);
    if (!chosen) return chosen.error();
    names = *std::move(chosen);
  }
  if (names.empty()) {
    text::Lines lines(text_);
    std::vector<std::string_view> fields;
    for (std::string_view line; names.empty() && lines.next(line);) {
      if (lines.number() <= format.skip_lines) continue;
      split_fields(uncommented(line), fields);
      if (std::any_of(fields.begin(), fields.end(), names_a_time)) {
        names.assign(fields.begin(), fields.end());
        first_line_ = lines.number();
      } else if (!is_comment(line)) {
        return Error{ErrorCode::parse,
                     "expected a line that names the columns, such as 't_s gx_radps ...', found '" +
                         text::printable(line) + "'",
                     source_, lines.number()};
      }
    }
    if (names.empty())
      return Error{ErrorCode::parse, "contains no line that names columns", source_};
  }
  column_count_ = names.size();
  for (std::size_t i = 0; i < names.size(); ++i)
    if (auto done = assign(names[i], static_cast<int>(i)); !done) return done;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int column = static_cast<int>(i);
    const bool used = column == time_column_ || column == time_second_column_ ||
                      std::any_of(slots_.begin(), slots_.end(),
                                  [&](const Slot& slot) { return slot.column == column; });
    if (used) {
      uses_.push_back({i + 1, headings_.empty() ? std::string() : headings_[i], names[i]});
    } else if (!format.choices.empty() && names[i] != "-") {
      return Error{ErrorCode::parse,
                   "'" + text::printable(names[i]) + "' is not a quantity of such a file", source_};
    }
  }
  return check_time();
}

Result<void> ColumnRows::assign(const std::string& name, int column) {
  const auto fault = [&](const std::string& what) {
    return Error{ErrorCode::parse, "column '" + text::printable(name) + "' " + what, source_,
                 first_line_};
  };
  const auto time = [&](TimeKind kind, int& slot, bool utc) -> Result<void> {
    if (slot >= 0) return fault("is a second time column");
    if (time_kind_ != TimeKind::none && time_kind_ != kind) return fault("is a second time column");
    time_kind_ = kind;
    slot = column;
    time_is_utc_ = utc;
    return {};
  };
  const ColumnName parts = split_name(name);
  if (name == "week") return time(TimeKind::week_tow, time_second_column_, false);
  if (name == "date") return time(TimeKind::calendar, time_second_column_, false);
  if (name == "clock") return time(TimeKind::calendar, time_column_, false);
  if (name == "utc_date") return time(TimeKind::calendar, time_second_column_, true);
  if (name == "utc_clock") return time(TimeKind::calendar, time_column_, true);
  if (names_a_time(name)) {
    time_decimals_ = static_cast<int>(find_unit(parts.unit, Dimension::time)->factor);
    if (parts.stem == "t") return time(TimeKind::log, time_column_, false);
    if (parts.stem == "tow") return time(TimeKind::week_tow, time_column_, false);
    return time(TimeKind::unix_like, time_column_, parts.stem == "utc");
  }
  for (Slot& slot : slots_) {
    const Quantity& q = slot.quantity;
    const bool bare = q.dimension == Dimension::none || q.dimension == Dimension::text;
    if (bare ? name != q.stem : (parts.stem != q.stem && name != q.stem)) continue;
    if (slot.column >= 0) return fault("occurs twice");
    if (!bare) {
      const Unit* unit = find_unit(parts.unit, q.dimension);
      if (unit == nullptr) return fault("needs one of the units " + units_of(q.dimension));
      slot.factor = unit->factor;
    }
    slot.column = column;
  }
  return {};
}

Result<void> ColumnRows::check_time() const {
  const bool two = time_kind_ == TimeKind::week_tow || time_kind_ == TimeKind::calendar;
  if (time_column_ >= 0 && (!two || time_second_column_ >= 0)) return {};
  return Error{ErrorCode::parse,
               "no column gives the time: t_s, week and tow_s, date and clock, or utc_s", source_,
               first_line_};
}

Result<void> ColumnRows::require(std::size_t first, std::size_t last) const {
  std::string missing;
  for (std::size_t i = first; i < last; ++i)
    if (!has(i)) missing += (missing.empty() ? "" : ", ") + std::string(slots_[i].quantity.stem);
  if (missing.empty()) return {};
  return Error{ErrorCode::parse, "has no column for " + missing, source_, first_line_};
}

std::string ColumnRows::read_time(std::span<const std::string_view> fields, LogTime& time) const {
  const std::string_view token = fields[static_cast<std::size_t>(time_column_)];
  const auto fault = [](std::string_view t) {
    return "not a time stamp: '" + text::printable(t) + "'";
  };
  std::int64_t base_s = 0;
  std::optional<std::int64_t> ns;
  if (time_kind_ == TimeKind::calendar) {
    const std::string_view date = fields[static_cast<std::size_t>(time_second_column_)];
    const std::optional<std::int64_t> day = date_seconds(date);
    if (!day) return fault(date);
    base_s = *day - kGpsEpochUnix_s;
    ns = clock_ns(token);
  } else {
    ns = decimal_ns(token, time_decimals_);
  }
  if (time_kind_ == TimeKind::week_tow) {
    const std::string_view week_token = fields[static_cast<std::size_t>(time_second_column_)];
    int week = -1;
    if (!text::to_number(week_token, week) || week < 0 || week > 6000) return fault(week_token);
    base_s = week * kWeek_s;
  }
  if (time_kind_ == TimeKind::unix_like) base_s = -kGpsEpochUnix_s;
  if (time_is_utc_) base_s += leap_seconds_;
  if (!ns || std::abs(static_cast<double>(*ns)) > 4e18) return fault(token);
  const std::int64_t total = *ns + base_s * kSecond_ns;
  if (total > kLargestStamp_ns || total < -kLargestStamp_ns) return fault(token);
  time = LogTime::from_nanoseconds(total);
  return {};
}

std::size_t ColumnRows::for_each(const std::function<std::string(const ColumnRow&)>& take,
                                 Problems& problems) const {
  std::vector<std::string_view> fields, texts(slots_.size());
  std::vector<double> numbers(slots_.size());
  const auto read_line = [&](std::string_view line, const text::Lines& lines) -> std::string {
    split_fields(line, fields);
    if (fields.size() != column_count_)
      return "expected " + std::to_string(column_count_) + " fields, found " +
             std::to_string(fields.size());
    const auto end = static_cast<std::size_t>(line.data() - text_.data()) + line.size();
    ColumnRow row{{}, lines.number(), end + (lines.terminated() ? 1 : 0), numbers, texts};
    if (std::string problem = read_time(fields, row.time); !problem.empty()) return problem;
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      const Slot& slot = slots_[i];
      numbers[i] = std::numeric_limits<double>::quiet_NaN();
      texts[i] =
          slot.column < 0 ? std::string_view() : fields[static_cast<std::size_t>(slot.column)];
      if (texts[i].empty() || slot.quantity.dimension == Dimension::text) continue;
      if (slot.quantity.dimension == Dimension::time) {
        const std::optional<std::int64_t> ns = decimal_ns(texts[i], static_cast<int>(slot.factor));
        if (!ns) return "not a time: '" + text::printable(texts[i]) + "'";
        numbers[i] = 1e-9 * static_cast<double>(*ns);
        continue;
      }
      if (!text::to_number(texts[i], numbers[i]))
        return "not a number: '" + text::printable(texts[i]) + "'";
      numbers[i] *= slot.factor;
    }
    return take(row);
  };
  const auto is_skipped = [&](std::string_view line, const text::Lines& lines) {
    return lines.number() <= first_line_ || is_comment(line);
  };
  return for_each_line(text_, source_, problems, is_skipped, read_line);
}

}  // namespace wayfare::io
