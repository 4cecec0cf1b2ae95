#pragma once

// What a program says about itself, in three forms from one table: --help, a man page and a
// completion of bash.

#include <deque>
#include <string>
#include <string_view>
#include <vector>

namespace wayfare::examples {

struct OptionHelp {
  std::vector<std::string> names = {};       ///< "--long" names, or one positional name
  std::string value = {};                    ///< what follows, such as NUMBER; empty for a flag
  std::string text = {};                     ///< meaning, with its unit
  std::vector<std::string> conditions = {};  ///< "0 to 1", "not with --obs"
  std::vector<std::string> choices = {};     ///< the words it accepts; empty: anything
  std::string initial = {};                  ///< shown default
  bool positional = false;
  bool required = false;
};

struct ExampleHelp {
  std::string arguments, task;
};

struct ProgramHelp {
  std::string name;  ///< of the executable
  std::string description;
  std::deque<OptionHelp> options;  ///< their addresses stay the same
  std::string more;  ///< after the options; lines that begin with a space stay as they are
  std::vector<ExampleHelp> examples;
};

/// At most 80 columns where words allow it.
[[nodiscard]] std::string to_help(const ProgramHelp& program);
/// In troff, for section 1.
[[nodiscard]] std::string to_man_page(const ProgramHelp& program, const std::string& version);
/// Options, words of choices, files and folders.
[[nodiscard]] std::string to_bash_completion(const ProgramHelp& program);

/// The candidate with the fewest insertions, deletions, replacements and swaps of neighbours to
/// `word`; empty if that is more than a third of its letters and more than two.
[[nodiscard]] std::string nearest(std::string_view word,
                                  const std::vector<std::string>& candidates);

}  // namespace wayfare::examples
