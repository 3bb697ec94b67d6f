// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/key_actions.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <array>

namespace cornice::viewer {
namespace {

constexpr std::array kBindings{
    KeyBinding{GLFW_KEY_F1, 0, Action::kHelp, "F1", true},
    KeyBinding{GLFW_KEY_F3, 0, Action::kFrames, "F3", true},
    KeyBinding{GLFW_KEY_F11, 0, Action::kFullScreen, "F11", true},
    KeyBinding{GLFW_KEY_F12, 0, Action::kPicture, "F12", true},
    KeyBinding{GLFW_KEY_ESCAPE, 0, Action::kClosePanels, "Esc", true},
    KeyBinding{GLFW_KEY_Z, GLFW_MOD_CONTROL, Action::kUndo, "Ctrl+Z"},
    KeyBinding{GLFW_KEY_Y, GLFW_MOD_CONTROL, Action::kRedo, "Ctrl+Y"},
    KeyBinding{GLFW_KEY_P, GLFW_MOD_CONTROL, Action::kPlayPath, "Ctrl+P"},
    KeyBinding{GLFW_KEY_Q, GLFW_MOD_CONTROL, Action::kQuit, "Ctrl+Q"},
    KeyBinding{GLFW_KEY_P, GLFW_MOD_SHIFT, Action::kSavePath, "Shift+P"},
    KeyBinding{GLFW_KEY_P, 0, Action::kAddToPath, "P"},
    KeyBinding{GLFW_KEY_G, 0, Action::kGoTo, "G"},
    KeyBinding{GLFW_KEY_L, 0, Action::kLayers, "L"},
    KeyBinding{GLFW_KEY_SPACE, 0, Action::kWalk, "Space"},
    KeyBinding{GLFW_KEY_HOME, 0, Action::kSeeAll, "Home"},
    KeyBinding{GLFW_KEY_B, 0, Action::kBookmark, "B"},
    KeyBinding{GLFW_KEY_N, 0, Action::kNextShading, "N"},
    KeyBinding{GLFW_KEY_C, 0, Action::kContours, "C"},
    KeyBinding{GLFW_KEY_X, 0, Action::kEdges, "X"},
    KeyBinding{GLFW_KEY_O, 0, Action::kNextCover, "O"},
    KeyBinding{GLFW_KEY_V, 0, Action::kNextSplit, "V"},
    KeyBinding{GLFW_KEY_K, 0, Action::kFreeze, "K"},
    KeyBinding{GLFW_KEY_1, 0, Action::kToggleLayer, "1..9", false, 9},
    KeyBinding{GLFW_KEY_TAB, 0, Action::kBlink, "Tab"},
};

constexpr std::array kHelp{
    HelpRow{"left drag", "turn around the point under the cursor; walking: look around"},
    HelpRow{"right drag", "move the ground with the cursor"},
    HelpRow{"middle drag", "look around"},
    HelpRow{"wheel", "towards the cursor and back; while flying or walking: speed"},
    HelpRow{"double click", "go there"},
    HelpRow{"W A S D", "fly, or walk"},
    HelpRow{"Q E", "fly down and up"},
    HelpRow{"Shift", "five times as fast"},
    HelpRow{"Space", "walk on the ground, fly again"},
    HelpRow{"Home", "see all"},
    HelpRow{"Ctrl+Z Ctrl+Y", "camera back and forth"},
    HelpRow{"G", "go to coordinates"},
    HelpRow{"B", "bookmark this view, see the layers' panel"},
    HelpRow{"N C X", "next shading, contour lines, edges"},
    HelpRow{"O", "photograph, differences, neither"},
    HelpRow{"V", "one picture, swipe line (drag it), side by side"},
    HelpRow{"K", "freeze what is chosen"},
    HelpRow{"L", "panel of layers"},
    HelpRow{"1..9", "show or hide a layer"},
    HelpRow{"Tab", "blink between the last two layers"},
    HelpRow{"P Shift+P Ctrl+P", "add this view to a path, save the path, play it"},
    HelpRow{"F1 Esc", "this help; close it"},
    HelpRow{"F3", "frame times"},
    HelpRow{"F11", "full screen"},
    HelpRow{"F12", "picture and its camera"},
    HelpRow{"Ctrl+Q", "quit"},
    HelpRow{"drop files", "hierarchy: a layer; raster: over the ground"},
};

constexpr int kSpecial = GLFW_MOD_CONTROL;

}  // namespace

std::span<const KeyBinding> key_bindings() { return kBindings; }

std::span<const HelpRow> help_rows() { return kHelp; }

std::optional<Asked> action_of(int key, int held, bool types) {
  // Bindings with Shift come before those without.
  for (const KeyBinding& binding : kBindings) {
    const int nth = key - binding.key;
    if (nth < 0 || nth >= binding.keys) continue;
    if (binding.counts_in_text) return Asked{binding.action, nth};
    if (types || (held & kSpecial) != (binding.held & kSpecial)) continue;
    if ((binding.held & ~held) == 0) return Asked{binding.action, nth};
  }
  return std::nullopt;
}

int key_by_name(int key, const char* name) {
  if (key < GLFW_KEY_A || key > GLFW_KEY_Z || name == nullptr || name[0] == '\0' || name[1] != '\0')
    return key;
  if (name[0] >= 'a' && name[0] <= 'z') return GLFW_KEY_A + (name[0] - 'a');
  if (name[0] >= 'A' && name[0] <= 'Z') return GLFW_KEY_A + (name[0] - 'A');
  return key;
}

}  // namespace cornice::viewer
