// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/input_queue.h"

#include <gtest/gtest.h>

namespace cornice::viewer {
namespace {

using Kind = InputEvent::Kind;

InputEvent button(bool is_down, double x = 0.0, double time_s = 0.0) {
  InputEvent event;
  event.kind = Kind::kButton;
  event.is_down = is_down;
  event.x = x;
  event.time_s = time_s;
  return event;
}

InputEvent move(double x) {
  InputEvent event;
  event.x = x;
  return event;
}

InputEvent key(int code, bool is_down, bool is_letter = false) {
  InputEvent event;
  event.kind = Kind::kKey;
  event.code = code;
  event.is_down = is_down;
  event.is_letter = is_letter;
  return event;
}

InputEvent character(int code) {
  InputEvent event;
  event.kind = Kind::kCharacter;
  event.code = code;
  return event;
}

InputQueue queue_of(const std::vector<InputEvent>& events) {
  InputQueue queue;
  for (const InputEvent& event : events) queue.add(event);
  return queue;
}

std::vector<std::size_t> sizes_of_frames(InputQueue queue, bool types) {
  std::vector<std::size_t> sizes;
  while (!queue.empty()) sizes.push_back(queue.take(types).size());
  return sizes;
}

TEST(InputQueue, GivesAFrameNothingWhereNothingHappened) {
  InputQueue queue;
  EXPECT_TRUE(queue.take(false).empty());
}

TEST(InputQueue, GivesTwoClicksDownAndUpTwice) {
  const auto queue = queue_of({button(true), button(false), button(true), button(false)});
  EXPECT_EQ(sizes_of_frames(queue, false), (std::vector<std::size_t>{1, 1, 1, 1}));
}

TEST(InputQueue, ClicksWhereTheCursorWas) {
  auto queue = queue_of({move(10.0), button(true, 10.0), move(90.0), button(false, 90.0)});
  const auto pressed = queue.take(false);
  ASSERT_EQ(pressed.size(), 2u);
  EXPECT_EQ(pressed.back().x, 10.0);
  const auto dragged = queue.take(false);
  ASSERT_EQ(dragged.size(), 1u) << "the drag comes before its end";
  EXPECT_EQ(dragged.back().x, 90.0);
  EXPECT_EQ(queue.take(false).back().kind, Kind::kButton);
  EXPECT_TRUE(queue.empty());
}

TEST(InputQueue, TakesAWholeMotionInOneFrame) {
  EXPECT_EQ(sizes_of_frames(queue_of({move(1.0), move(2.0), move(3.0)}), false),
            (std::vector<std::size_t>{3}));
}

TEST(InputQueue, KeepsEveryEventInItsOrder) {
  std::vector<InputEvent> all;
  for (int i = 0; i < 200; ++i) {
    const bool is_down = i % 3 == 0;
    all.push_back(i % 5 == 0 ? move(i) : i % 5 < 3 ? button(is_down, i) : key(i % 4, is_down));
    all.back().scancode = i;
  }
  for (const bool types : {false, true}) {
    InputQueue queue = queue_of(all);
    int next = 0;
    while (!queue.empty()) {
      const auto frame = queue.take(types);
      ASSERT_FALSE(frame.empty()) << "stands still";
      for (const InputEvent& event : frame) EXPECT_EQ(event.scancode, next++);
    }
    EXPECT_EQ(next, 200);
  }
}

TEST(InputQueue, GivesOneCommandAFrame) {
  const auto queue = queue_of({key(78, true, true), key(78, false, true), key(78, true, true),
                               key(78, false, true), key(71, true, true)});
  EXPECT_EQ(sizes_of_frames(queue, false), (std::vector<std::size_t>{1, 1, 1, 2})) << "n n g";
}

TEST(InputQueue, LetsAModifierComeWithItsKey) {
  InputEvent control = key(341, true);
  control.is_modifier = true;
  EXPECT_EQ(sizes_of_frames(queue_of({control, key(90, true, true)}), false),
            (std::vector<std::size_t>{2}));
}

TEST(InputQueue, TypesAWholeTextInOneFrameButWhatEditsItInItsTurn) {
  constexpr int kBackspace = 259;
  const std::vector<InputEvent> typed{
      key(52, true, true),    character('4'),        key(52, false, true),
      key(53, true, true),    character('5'),        key(kBackspace, true),
      key(kBackspace, false), key(kBackspace, true), character('6')};
  EXPECT_EQ(sizes_of_frames(queue_of(typed), true), (std::vector<std::size_t>{6, 1, 1, 1}));
}

TEST(InputQueue, KnowsADoubleClickByTimeAndPlace) {
  const auto is_double = [](double dx, double seconds, double frame_s) {
    InputQueue queue;
    queue.add(button(true, 100.0, 1.0), frame_s);
    queue.add(button(false, 100.0, 1.0), frame_s);
    queue.add(button(true, 100.0 + dx, 1.0 + seconds), frame_s);
    bool found = false;
    while (!queue.empty())
      for (const InputEvent& event : queue.take(false)) found |= event.is_second;
    return found;
  };
  EXPECT_TRUE(is_double(2.0, 0.2, 0.0));
  EXPECT_FALSE(is_double(20.0, 0.2, 0.0)) << "elsewhere";
  EXPECT_FALSE(is_double(0.0, 0.5, 0.0)) << "too late";
  EXPECT_TRUE(is_double(0.0, 0.5, 1.0)) << "frames of a second tell times no better";
}

TEST(InputQueue, TakesAThirdPressForANewClick) {
  InputQueue queue;
  int doubles = 0;
  for (int i = 0; i < 4; ++i) {
    queue.add(button(true));
    queue.add(button(false));
  }
  while (!queue.empty())
    for (const InputEvent& event : queue.take(false)) doubles += event.is_second;
  EXPECT_EQ(doubles, 2);
}

}  // namespace
}  // namespace cornice::viewer
