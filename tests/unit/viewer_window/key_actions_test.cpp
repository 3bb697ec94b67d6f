// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/key_actions.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

namespace cornice::viewer {
namespace {

using Names = std::set<std::string>;

/// Of what is parted by blanks and commas, without words of the mouse and of dragging in, which
/// begin with a small letter.
void add_keys(const std::string& text, Names& names) {
  std::istringstream in(text);
  for (std::string word; in >> word;) {
    word.erase(std::remove(word.begin(), word.end(), ','), word.end());
    if (!word.empty() && std::islower(static_cast<unsigned char>(word.front())) == 0)
      names.insert(word);
  }
}

Names bound_keys() {
  Names names{"W", "A", "S", "D", "Q", "E", "Shift"};
  for (const KeyBinding& binding : key_bindings()) names.insert(binding.name);
  return names;
}

TEST(Keys, AreExactlyThoseOfTheHelp) {
  Names names;
  for (const HelpRow& row : help_rows()) add_keys(row.keys, names);
  EXPECT_EQ(names, bound_keys());
}

TEST(Keys, AreExactlyThoseOfTheReadme) {
  std::ifstream in(CORNICE_SOURCE_DIR "/terrain-viewer/README.md");
  ASSERT_TRUE(in);
  Names names;
  bool is_table = false;
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("| key, mouse |", 0) == 0) is_table = true;
    if (is_table && line.empty()) break;
    if (!is_table || line.rfind("|---", 0) == 0 || line.rfind("| key", 0) == 0) continue;
    add_keys(line.substr(1, line.find('|', 1) - 1), names);
  }
  EXPECT_EQ(names, bound_keys());
}

TEST(Keys, AllDoSomethingAndNoTwoTheSame) {
  Names names;
  std::set<Action> actions;
  for (const KeyBinding& binding : key_bindings()) {
    EXPECT_TRUE(names.insert(binding.name).second) << binding.name;
    EXPECT_TRUE(actions.insert(binding.action).second) << binding.name;
    const auto asked = action_of(binding.key, binding.held, false);
    ASSERT_TRUE(asked) << binding.name;
    EXPECT_EQ(asked->action, binding.action) << binding.name;
  }
  EXPECT_EQ(actions.size(), static_cast<std::size_t>(Action::kBlink) + 1) << "the last of them";
}

TEST(Keys, CountWithTheModifiersThatTheyNeed) {
  EXPECT_EQ(action_of(GLFW_KEY_P, 0, false)->action, Action::kAddToPath);
  EXPECT_EQ(action_of(GLFW_KEY_P, GLFW_MOD_SHIFT, false)->action, Action::kSavePath);
  EXPECT_EQ(action_of(GLFW_KEY_P, GLFW_MOD_CONTROL, false)->action, Action::kPlayPath);
  EXPECT_EQ(action_of(GLFW_KEY_N, GLFW_MOD_SHIFT | GLFW_MOD_CAPS_LOCK, false)->action,
            Action::kNextShading)
      << "flying fast";
  EXPECT_FALSE(action_of(GLFW_KEY_N, GLFW_MOD_CONTROL, false));
  EXPECT_FALSE(action_of(GLFW_KEY_Z, 0, false));
  EXPECT_FALSE(action_of(GLFW_KEY_W, 0, false)) << "flying is no press";
}

TEST(Keys, OfTextDoNothingWhileTextIsEntered) {
  for (const KeyBinding& binding : key_bindings())
    EXPECT_EQ(action_of(binding.key, binding.held, true).has_value(), binding.counts_in_text)
        << binding.name;
}

TEST(Keys, NumbersTellWhichLayer) {
  for (int n = 0; n < 9; ++n) {
    const auto asked = action_of(GLFW_KEY_1 + n, 0, false);
    ASSERT_TRUE(asked);
    EXPECT_EQ(asked->action, Action::kToggleLayer);
    EXPECT_EQ(asked->nth, n);
  }
  EXPECT_FALSE(action_of(GLFW_KEY_0, 0, false));
}

TEST(Keys, AreThoseThatCarryTheLetterOnKeyboardsThatDiffer) {
  EXPECT_EQ(key_by_name(GLFW_KEY_Y, "z"), GLFW_KEY_Z) << "QWERTZ";
  EXPECT_EQ(key_by_name(GLFW_KEY_A, "Q"), GLFW_KEY_Q) << "AZERTY";
  EXPECT_EQ(key_by_name(GLFW_KEY_N, nullptr), GLFW_KEY_N);
  EXPECT_EQ(key_by_name(GLFW_KEY_N, ""), GLFW_KEY_N);
  EXPECT_EQ(key_by_name(GLFW_KEY_N, "\xd1\x82"), GLFW_KEY_N) << "a letter of another script";
  EXPECT_EQ(key_by_name(GLFW_KEY_1, "q"), GLFW_KEY_1);
  EXPECT_EQ(key_by_name(GLFW_KEY_F1, nullptr), GLFW_KEY_F1);
}

}  // namespace
}  // namespace cornice::viewer
