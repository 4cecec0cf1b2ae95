#include "command_line.hpp"

#include <cstdint>
#include <cstdio>
#include <utility>

#include <CLI/CLI.hpp>

namespace wayfare::examples {

Option& Option::required() {
  option_->required();
  return *this;
}
Option& Option::show_default() {
  option_->capture_default_str();
  return *this;
}
Option& Option::range(int low, int high) {
  option_->check(CLI::Range(low, high));
  return *this;
}
Option& Option::range(double low, double high) {
  option_->check(CLI::Range(low, high));
  return *this;
}
Option& Option::positive() {
  option_->check(CLI::PositiveNumber);
  return *this;
}
Option& Option::not_negative() {
  option_->check(CLI::NonNegativeNumber);
  return *this;
}
Option& Option::existing_file() {
  option_->check(CLI::ExistingFile);
  return *this;
}
Option& Option::existing_folder() {
  option_->check(CLI::ExistingDirectory);
  return *this;
}
Option& Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return *this;
}
Option& Option::expected(int count) {
  option_->expected(count);
  return *this;
}
Option& Option::expected(int least, int most) {
  option_->expected(least, most);
  return *this;
}
Option& Option::delimiter(char between) {
  option_->delimiter(between);
  return *this;
}
Option& Option::take_all() {
  option_->take_all();
  return *this;
}
Option& Option::needs(const std::string& other) {
  option_->needs(other);
  return *this;
}
Option& Option::excludes(const std::string& other) {
  option_->excludes(other);
  return *this;
}

CommandLine::CommandLine(const std::string& description)
    : app_(std::make_unique<CLI::App>(description)) {}
CommandLine::~CommandLine() = default;

template <class Value>
Option CommandLine::add_option(const std::string& name, Value& value, const std::string& help) {
  return Option(app_->add_option(name, value, help));
}

using Text = const std::string&;
template Option CommandLine::add_option(Text, int&, Text);
template Option CommandLine::add_option(Text, unsigned&, Text);
template Option CommandLine::add_option(Text, double&, Text);
template Option CommandLine::add_option(Text, std::size_t&, Text);
template Option CommandLine::add_option(Text, std::uint16_t&, Text);
template Option CommandLine::add_option(Text, std::string&, Text);
template Option CommandLine::add_option(Text, std::optional<double>&, Text);
template Option CommandLine::add_option(Text, std::vector<int>&, Text);
template Option CommandLine::add_option(Text, std::vector<double>&, Text);
template Option CommandLine::add_option(Text, std::vector<std::string>&, Text);
template Option CommandLine::add_option(Text, std::vector<std::pair<double, double>>&, Text);

Option CommandLine::add_flag(const std::string& name, bool& value, const std::string& help) {
  return Option(app_->add_flag(name, value, help));
}

Option CommandLine::add_word(const std::string& name, const std::string& help,
                             const std::function<void(const std::string&)>& take) {
  return Option(app_->add_option_function<std::string>(name, take, help));
}

Option CommandLine::add_print(const std::string& name, const std::function<std::string()>& text,
                              const std::string& help) {
  const auto print = [text] {
    std::fputs(text().c_str(), stdout);
    throw CLI::Success();
  };
  return Option(app_->add_flag_callback(name, print, help));
}

void CommandLine::footer(const std::string& text) { app_->footer(text); }

std::optional<int> CommandLine::parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& end) {
    return app_->exit(end);
  }
  return std::nullopt;
}

}  // namespace wayfare::examples
