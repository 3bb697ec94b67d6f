// SPDX-License-Identifier: GPL-3.0-or-later
// What keys do, and the help that says so. Knows no window.
#pragma once

#include <optional>
#include <span>

namespace cornice::viewer {

enum class Action {
  kHelp,
  kFrames,
  kFullScreen,
  kPicture,
  kClosePanels,
  kUndo,
  kRedo,
  kPlayPath,
  kQuit,
  kGoTo,
  kLayers,
  kWalk,
  kSeeAll,
  kBookmark,
  kAddToPath,
  kSavePath,
  kNextShading,
  kContours,
  kEdges,
  kNextCover,
  kNextSplit,
  kFreeze,
  kToggleLayer,
  kBlink
};

struct KeyBinding {
  int key = 0;   ///< GLFW_KEY_, the first of several
  int held = 0;  ///< GLFW_MOD_CONTROL, GLFW_MOD_SHIFT or none
  Action action = Action::kHelp;
  const char* name = "";        ///< as help and README write it
  bool counts_in_text = false;  ///< while text is entered, too
  int keys = 1;                 ///< so many in a row
};
std::span<const KeyBinding> key_bindings();

/// What a key asks for.
struct Asked {
  Action action = Action::kHelp;
  int nth = 0;  ///< of the binding's keys, from 0
};

/// held: GLFW_MOD_ bits; Shift counts only where it makes a difference. types: text is being
/// entered. Nothing for a key that does nothing then.
std::optional<Asked> action_of(int key, int held, bool types);

/// The key that carries a letter: keyboards differ in where they have it. name: what is written on
/// the key, as glfwGetKeyName says, or null.
int key_by_name(int key, const char* name);

/// A line of the help, mouse and flying included. Keys are parted by blanks.
struct HelpRow {
  const char* keys;
  const char* does;
};
std::span<const HelpRow> help_rows();

}  // namespace cornice::viewer
