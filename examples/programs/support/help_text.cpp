#include "help_text.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace wayfare::examples {
namespace {

constexpr std::size_t kWidth = 80, kTextColumn = 30;

constexpr std::array<std::pair<const char*, const char*>, 4> kExitCodes{
    {{"0", "done"},
     {"1", "a file, a device or its data cannot be used"},
     {"2", "wrong arguments"},
     {"3", "done, but the result is in doubt, for the reason printed"}}};

std::string join(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

/// In characters of UTF-8.
std::size_t width_of(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

/// Appends words, with new lines at `indent`; the first word is at `column`.
void append_wrapped(std::string& out, std::string_view line, std::size_t indent,
                    std::size_t column) {
  bool first = true;
  while (!line.empty()) {
    const std::size_t end = std::min(line.find(' '), line.size());
    const std::string_view word = line.substr(0, end);
    line.remove_prefix(std::min(end + 1, line.size()));
    if (word.empty()) continue;
    if (!first && column + 1 + width_of(word) > kWidth) {
      out += '\n' + std::string(indent, ' ');
      column = indent;
    } else if (!first) {
      out += ' ';
      ++column;
    }
    out += word;
    column += width_of(word);
    first = false;
  }
  out += '\n';
}

template <class Take>
void each_line(std::string_view text, const Take& take) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    take(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

std::string wrapped(std::string_view text) {
  std::string out;
  each_line(text, [&](std::string_view line) {
    if (line.starts_with(' ')) {
      out += std::string(line) + '\n';
    } else {
      append_wrapped(out, line, 0, 0);
    }
  });
  return out;
}

/// The meaning, and in brackets what an option accepts.
std::string meaning(const OptionHelp& option) {
  std::vector<std::string> notes = option.conditions;
  if (!option.choices.empty() && option.value == "WORD")
    notes.insert(notes.begin(), "one of " + join(option.choices, ", "));
  if (!option.initial.empty()) notes.push_back("default " + option.initial);
  if (option.required && !option.positional) notes.push_back("required");
  if (notes.empty()) return option.text;
  return option.text + " (" + join(notes, "; ") + ")";
}

std::string left_of(const OptionHelp& option) {
  const std::string names = join(option.names, ", ");
  return option.value.empty() || option.positional ? names : names + " " + option.value;
}

void append_option(std::string& out, const std::string& left, const std::string& text) {
  out += "  " + left;
  std::size_t column = 2 + width_of(left);
  if (column + 2 > kTextColumn) {
    out += '\n';
    column = 0;
  }
  out += std::string(kTextColumn - column, ' ');
  append_wrapped(out, text, kTextColumn, kTextColumn);
}

std::string usage(const ProgramHelp& program) {
  std::string text = program.name + " [OPTIONS]";
  for (const OptionHelp& o : program.options) {
    if (o.required && !o.positional) text += " " + o.names.front() + " " + o.value;
  }
  for (const OptionHelp& o : program.options) {
    if (!o.positional) continue;
    const std::string name = o.names.front() + (o.value.ends_with("...") ? "..." : "");
    text += o.required ? " " + name : " [" + name + "]";
  }
  return text;
}

std::string in_troff(std::string_view text) {
  std::string out;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
    line_begins = c == '\n';
  }
  return out;
}

/// The first sentence, for lists of pages.
std::string summary_of(const std::string& description) {
  std::size_t end = description.size();
  for (const char* stop : {". ", ".\n", ": ", "; ", "\n"})
    end = std::min(end, description.find(stop));
  std::string text = description.substr(0, end);
  while (text.ends_with('.')) text.pop_back();
  return text;
}

void append_troff_paragraphs(std::string& out, std::string_view text) {
  bool literal = false;
  each_line(text, [&](std::string_view line) {
    const bool as_it_is = line.starts_with(' ');
    if (as_it_is != literal) out += as_it_is ? ".PP\n.nf\n" : ".fi\n";
    literal = as_it_is;
    if (!literal) out += ".PP\n";
    out += in_troff(line) + '\n';
  });
  if (literal) out += ".fi\n";
}

std::string shell_words(const std::vector<std::string>& words) {
  return "'" + join(words, " ") + "'";  // options and choices have no quotes
}

std::string complete_of(const OptionHelp& option) {
  if (!option.choices.empty()) return "-W " + shell_words(option.choices);
  if (option.value.starts_with("DIR")) return "-d";
  return option.value.starts_with("FILE") ? "-f" : std::string();
}

}  // namespace

std::string to_help(const ProgramHelp& program) {
  std::string out = wrapped(program.description) + "\nUsage: " + usage(program) + "\n";
  const auto append = [&](const char* title, bool positional) {
    out += std::string("\n") + title + ":\n";
    for (const OptionHelp& option : program.options)
      if (option.positional == positional) append_option(out, left_of(option), meaning(option));
  };
  if (std::ranges::any_of(program.options, &OptionHelp::positional)) append("Arguments", true);
  append("Options", false);
  if (!program.more.empty()) out += "\n" + wrapped(program.more);
  if (!program.examples.empty()) out += "\nExamples:\n";
  for (const ExampleHelp& example : program.examples) {
    out += "  " + program.name + " " + example.arguments + "\n      ";
    append_wrapped(out, example.task, 6, 6);
  }
  out += "\nExit codes:\n";
  for (const auto& [code, text] : kExitCodes) out += std::string("  ") + code + "  " + text + "\n";
  return out;
}

std::string to_man_page(const ProgramHelp& program, const std::string& version) {
  std::string out = ".TH \"" + in_troff(program.name) + "\" 1 \"\" \"wayfare " + version +
                    "\" \"wayfare programs\"\n.SH NAME\n" + in_troff(program.name) + " \\- " +
                    in_troff(summary_of(program.description)) + "\n.SH SYNOPSIS\n" +
                    in_troff(usage(program)) + "\n.SH DESCRIPTION\n";
  append_troff_paragraphs(out, program.description);
  out += ".SH OPTIONS\n";
  for (const OptionHelp& option : program.options)
    out += ".TP\n\\fB" + in_troff(left_of(option)) + "\\fR\n" + in_troff(meaning(option)) + "\n";
  if (!program.more.empty()) out += ".SH NOTES\n";
  append_troff_paragraphs(out, program.more);
  if (!program.examples.empty()) out += ".SH EXAMPLES\n";
  for (const ExampleHelp& example : program.examples)
    out += ".TP\n" + in_troff(program.name + " " + example.arguments) + "\n" +
           in_troff(example.task) + "\n";
  out += ".SH \"EXIT STATUS\"\n";
  for (const auto& [code, text] : kExitCodes)
    out += std::string(".TP\n") + code + "\n" + text + "\n";
  return out;
}

std::string to_bash_completion(const ProgramHelp& program) {
  std::string function = "_wayfare_" + program.name;
  std::ranges::replace(function, '-', '_');
  std::vector<std::string> all;
  std::string cases;
  std::string positional;
  for (const OptionHelp& option : program.options) {
    if (option.positional) {
      if (positional.empty()) positional = complete_of(option);
      continue;
    }
    all.insert(all.end(), option.names.begin(), option.names.end());
    if (option.value.empty()) continue;
    const std::string how = complete_of(option);
    cases += "    " + join(option.names, "|") + ") " +
             (how.empty() ? "" : "COMPREPLY=($(compgen " + how + " -- \"$word\")); ") +
             "return ;;\n";
  }
  return function +
         "() {\n  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
         "  if [[ $word == = ]]; then word=; elif [[ $before == = ]]; then "
         "before=${COMP_WORDS[COMP_CWORD-2]}; fi\n  COMPREPLY=()\n  case $before in\n" +
         cases + "  esac\n  if [[ $word == -* ]]; then\n    COMPREPLY=($(compgen -W " +
         shell_words(all) + " -- \"$word\"))\n  else\n    COMPREPLY=($(compgen " +
         (positional.empty() ? "-f" : positional) +
         " -- \"$word\"))\n  fi\n}\ncomplete -o filenames -F " + function + " " + program.name +
         "\n";
}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    // Rows of the distances between beginnings of `word` and of the candidate.
    std::vector<std::vector<std::size_t>> d(word.size() + 1,
                                            std::vector<std::size_t>(candidate.size() + 1));
    for (std::size_t i = 0; i <= word.size(); ++i)
      for (std::size_t k = 0; k <= candidate.size(); ++k) {
        if (i == 0 || k == 0) {
          d[i][k] = i + k;
          continue;
        }
        const bool same = word[i - 1] == candidate[k - 1];
        d[i][k] = std::min({d[i - 1][k] + 1, d[i][k - 1] + 1, d[i - 1][k - 1] + (same ? 0 : 1)});
        if (i > 1 && k > 1 && word[i - 1] == candidate[k - 2] && word[i - 2] == candidate[k - 1])
          d[i][k] = std::min(d[i][k], d[i - 2][k - 2] + 1);
      }
    if (d[word.size()][candidate.size()] >= least) continue;
    least = d[word.size()][candidate.size()];
    best = candidate;
  }
  return best;
}

}  // namespace wayfare::examples
