#include "command_line.hpp"

#include <cstdint>
#include <cstdio>
#include <utility>

#include <CLI/CLI.hpp>

namespace wayfare::examples {

Option& Option::required() { return option_->required(), *this; }
Option& Option::show_default() { return option_->capture_default_str(), *this; }
Option& Option::range(int low, int high) { return option_->check(CLI::Range(low, high)), *this; }
Option& Option::range(double low, double high) {
  return option_->check(CLI::Range(low, high)), *this;
}
Option& Option::positive() { return option_->check(CLI::PositiveNumber), *this; }
Option& Option::not_negative() { return option_->check(CLI::NonNegativeNumber), *this; }
Option& Option::existing_file() { return option_->check(CLI::ExistingFile), *this; }
Option& Option::existing_folder() { return option_->check(CLI::ExistingDirectory), *this; }
Option& Option::one_of(const std::vector<std::string>& words) {
  return option_->check(CLI::IsMember(words)), *this;
}
Option& Option::expected(int count) { return option_->expected(count), *this; }
Option& Option::expected(int least, int most) { return option_->expected(least, most), *this; }
Option& Option::delimiter(char between) { return option_->delimiter(between), *this; }
Option& Option::take_all() { return option_->take_all(), *this; }
Option& Option::needs(const std::string& other) { return option_->needs(other), *this; }
Option& Option::excludes(const std::string& other) { return option_->excludes(other), *this; }
bool Option::given() const { return option_->count() > 0; }
std::string Option::name() const { return option_->get_name(); }

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

int exit_code(const char* program, const Result<void>& done) {
  if (done) return 0;
  std::fprintf(stderr, "%s: %s\n", program, done.error().to_string().c_str());
  return 1;
}

std::optional<int> CommandLine::parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& end) {
    return app_->exit(end);
  }
  return std::nullopt;
}

}  // namespace wayfare::examples
