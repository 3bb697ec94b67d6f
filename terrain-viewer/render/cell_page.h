// SPDX-License-Identifier: GPL-3.0-or-later
// Room for cells on the GPU comes in pages, pairs of buffers that never grow: what was put there
// is never copied, and a frame never waits for more than one page. Drivers that fill new memory
// take a second or two for a gigabyte, so a thread with a context of its own can make pages
// beforehand.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "terrain-viewer/render/gl.h"
#include "terrain-viewer/stream/packed_cell.h"

namespace cornice::viewer {

/// Vertices with their parents, and indices.
struct PageSize {
  std::uint64_t vertices = 0, indices = 0;
  constexpr std::uint64_t bytes() const { return vertices * kWordsPerVertex * 4 + indices * 2; }
};

struct PageBuffers {
  GlBuffer vertices, indices;
};

/// Throws RunError where the GPU has no room for it.
PageBuffers make_page_buffers(const PageSize& size);

/// An OpenGL context that shares objects with that of the thread that draws.
class SecondContext {
 public:
  virtual ~SecondContext() = default;
  /// On the thread that uses it; false where the system refuses.
  virtual bool make_current() = 0;
  /// The same thread leaves it.
  virtual void release() = 0;
};

/// Makes one page at a time on a thread of its own. All functions are for the thread that draws.
class PageMaker {
 public:
  /// Starts the thread, which alone uses `context`; ends with the maker.
  explicit PageMaker(std::unique_ptr<SecondContext> context);
  ~PageMaker();
  PageMaker(const PageMaker&) = delete;
  PageMaker& operator=(const PageMaker&) = delete;

  /// Begins one; none may be under way.
  void want(const PageSize& size);
  /// True from want() until take() has given the page away.
  bool is_under_way() const { return size_.has_value(); }
  /// Of the page that is under way.
  PageSize size() const { return size_.value_or(PageSize{}); }

  struct Made {
    PageSize size;
    PageBuffers buffers;  ///< of id 0 where the GPU had no room
  };
  /// The page, once it is made; waits for that if told to. Empty otherwise.
  std::optional<Made> take(bool waits);

 private:
  struct State;
  std::unique_ptr<State> state_;
  std::optional<PageSize> size_;
};

}  // namespace cornice::viewer
