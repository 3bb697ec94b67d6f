// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/base/error.h"

namespace cornice {
namespace {

constexpr int kHelpColumns = 100;
constexpr std::size_t kHelpIndent = 32;

std::string cli11_name(const Option& option) {
  std::string title = option.title();
  if (option.is_positional() || option.short_flag() == '\0') return title;
  return std::string("-") + option.short_flag() + "," + title;
}

/// Words given to an option, in the order of the options.
using GivenWords = std::vector<std::pair<bool, std::vector<std::string>>>;

void declare(CLI::App& app, const std::vector<Option>& options, GivenWords& given) {
  given.resize(options.size());
  for (std::size_t i = 0; i < options.size(); ++i) {
    const Option& option = options[i];
    auto& words = given[i];
    if (option.is_flag()) {
      app.add_flag_callback(cli11_name(option), [&words] { words.first = true; })
          ->disable_flag_override();
      continue;
    }
    CLI::Option* declared =
        app.add_option(cli11_name(option), [&words](const CLI::results_t& results) {
          words = {true, results};
          return true;
        });
    if (option.takes_many()) {
      declared->expected(1, CLI::detail::expected_max_vector_size)->allow_extra_args();
    } else {
      declared->expected(1);
    }
  }
}

std::vector<std::string> known_flags(const std::vector<Option>& options) {
  std::vector<std::string> flags{"--help", "--help-all", "--version"};
  for (const Option& option : options) {
    if (!option.is_positional()) flags.push_back(option.title());
  }
  return flags;
}

[[noreturn]] void refuse_extra(const std::string& word, const std::vector<Option>& options) {
  if (word.size() > 1 && word[0] == '-') {
    const std::string flag = word.substr(0, word.find('='));
    throw UsageError(flag, "unknown option" + did_you_mean(flag, known_flags(options)));
  }
  throw UsageError("'" + word + "'", "is one argument too many");
}

/// "--threads: needs a value": CLI11's own sentences, made ours where they are about one option.
[[noreturn]] void refuse(const CLI::ParseError& error) {
  std::string text = error.what();
  std::replace(text.begin(), text.end(), '\n', ' ');
  throw UsageError("", text);
}

}  // namespace

CommandAction parse_command_line(int argc, const char* const* argv, std::vector<Option>& options) {
  CLI::App app;
  app.set_help_flag("");
  app.allow_extras();
  bool help = false;
  bool help_all = false;
  bool version = false;
  app.add_flag("-h,--help", help);
  app.add_flag("--help-all", help_all);
  app.add_flag("-v,--version", version);
  GivenWords given;
  declare(app, options, given);
  // Asked for help, nothing else on the line matters.
  const std::vector<std::string_view> arguments(argv + std::min(argc, 1), argv + argc);
  const auto asked = [&](std::string_view flag) {
    const auto end = std::find(arguments.begin(), arguments.end(), "--");
    return std::find(arguments.begin(), end, flag) != end;
  };
  if (asked("--help-all")) return CommandAction::kHelpAll;
  if (asked("--help") || asked("-h")) return CommandAction::kHelp;
  if (asked("--version") || asked("-v")) return CommandAction::kVersion;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    refuse(error);
  }
  for (const std::string& word : app.remaining()) {
    if (word != "--") refuse_extra(word, options);
  }
  for (std::size_t i = 0; i < options.size(); ++i) {
    if (given[i].first) options[i].parse(given[i].second);
  }
  check_options(options);
  return CommandAction::kRun;
}

namespace {

std::string flag_column(const Option& option) {
  std::string text = option.title();
  if (option.short_flag() != '\0') text = std::string("-") + option.short_flag() + ", " + text;
  const std::string type = option.type_text();
  if (!type.empty() && !option.is_positional()) text += " " + type;
  return text;
}

std::string explanation(const Option& option) {
  std::string text = option.help();
  const std::string range = option.range_text();
  std::vector<std::string> facts;
  if (!range.empty()) {
    facts.push_back(range);
  } else if (!option.unit().empty()) {
    facts.push_back(option.unit());
  }
  const bool told = !option.default_text().empty() && !option.is_flag() && !option.is_required();
  if (told) facts.push_back("default " + option.default_text());
  if (option.is_required() && !option.is_positional()) facts.emplace_back("required");
  if (facts.empty()) return text;
  text += " (" + facts[0];
  for (std::size_t i = 1; i < facts.size(); ++i) text += "; " + facts[i];
  return text + ")";
}

/// Words of `text` in lines up to kHelpColumns, all but the first indented.
std::string wrapped(const std::string& text, std::size_t column) {
  std::string out;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const bool first = out.empty();
    if (!first && column + 1 + word.size() > kHelpColumns) {
      out += "\n" + std::string(kHelpIndent, ' ');
      column = kHelpIndent;
    } else if (!first) {
      out += " ";
      ++column;
    }
    out += word;
    column += word.size();
  }
  return out;
}

std::string option_lines(const Option& option) {
  std::string left = "  " + flag_column(option);
  if (left.size() + 2 > kHelpIndent) {
    left += "\n" + std::string(kHelpIndent, ' ');
  } else {
    left.resize(kHelpIndent, ' ');
  }
  return left + wrapped(explanation(option), kHelpIndent) + "\n";
}

std::string usage_line(const HelpPage& page, const std::vector<Option>& options) {
  std::string line = "Usage: " + page.tool;
  for (const Option& option : options) {
    if (!option.is_positional()) continue;
    const std::string name = option.title() + (option.takes_many() ? "..." : "");
    line += " " + (option.is_required() ? name : "[" + name + "]");
  }
  for (const Option& option : options) {
    if (option.is_positional() || !option.is_required()) continue;
    const std::string flag =
        option.short_flag() == '\0' ? option.title() : std::string("-") + option.short_flag();
    line += " " + flag + " " + option.type_text();
  }
  return line + " [options]\n";
}

}  // namespace

std::string help_text(const HelpPage& page, const std::vector<Option>& options, bool all) {
  std::string text = page.description + ".\n\n" + usage_line(page, options);
  std::vector<std::string> groups;
  for (const Option& option : options) {
    if (option.is_advanced() && !all) continue;
    if (std::find(groups.begin(), groups.end(), option.group()) == groups.end()) {
      groups.push_back(option.group());
    }
  }
  bool hidden = false;
  for (const std::string& group : groups) {
    text += group.empty() ? "\n" : "\n" + group + "\n";
    for (const Option& option : options) {
      if (option.group() == group && (all || !option.is_advanced())) text += option_lines(option);
    }
  }
  for (const Option& option : options) hidden = hidden || (option.is_advanced() && !all);
  if (!page.examples.empty()) text += "\nExamples\n";
  for (const std::string& example : page.examples) text += "  " + example + "\n";
  if (hidden) text += "\nAll options: " + page.tool + " --help-all\n";
  return text;
}

}  // namespace cornice
