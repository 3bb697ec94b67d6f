// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/window.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/cli/log.h"
#include "terrain-viewer/app/dropped_files.h"
#include "terrain-viewer/app/failure_log.h"
#include "terrain-viewer/app/frame_pacer.h"
#include "terrain-viewer/app/key_actions.h"
#include "terrain-viewer/app/look_actions.h"
#include "terrain-viewer/app/new_file.h"
#include "terrain-viewer/app/panels.h"
#include "terrain-viewer/app/pick.h"
#include "terrain-viewer/app/picture.h"
#include "terrain-viewer/app/pilot.h"
#include "terrain-viewer/app/read_out.h"
#include "terrain-viewer/app/session.h"
#include "terrain-viewer/app/welcome.h"
#include "terrain-viewer/app/window_input.h"
#include "terrain-viewer/app/window_system.h"
#include "terrain-viewer/scene/camera_file.h"

namespace cornice::viewer {
namespace {

/// Targets of the window's size.
struct Canvas {
  Canvas(int width, int height, int samples)
      : drawn(width, height, samples), shown(width, height, 1) {}
  Target drawn, shown;
};

Camera first_camera(const Options& options, const SceneBox& box, double width_over_height) {
  return options.camera.empty() ? seeing_all({}, box.lowest, box.highest, width_over_height)
                                : read_camera(options.camera);
}

class WindowApp {
 public:
  WindowApp(const Options& options, SettingsRead settings, WindowSystem& window, Report& report,
            Progress& progress)
      : options_(options),
        report_(report),
        progress_(progress),
        settings_(std::move(settings.settings)),
        window_(window),
        session_(options),
        read_out_(session_.layers().front()->file().header().crs_text),
        pilot_(first_pilot()),
        input_(window.get()),
        pacer_(glfwGetTime()) {
    if (auto second = window_.second()) session_.make_room_ahead(std::move(second));
    panels_.message =
        settings.problem.empty() ? "F1 lists what keys and the mouse do" : settings.problem;
    panels_.shows_layers = settings_.shows_layers;
    panels_.shows_frames = settings_.shows_frames;
    if (options.side_by_side) panels_.split = Split::Kind::kSideBySide;
    for (const auto& file : options.files) opened(file);
    panels_.bookmarks = settings_.bookmarks_of(options.files.front());
  }

  void run() {
    try {
      while (glfwWindowShouldClose(window_.get()) == GLFW_FALSE && !progress_.cancelled()) {
        take_news();
        if (const auto next = pacer_.next(glfwGetTime()); next && !is_hidden()) frame(*next);
      }
    } catch (...) {
      // Bookmarks outlive what ends the window.
      keep_settings();
      throw;
    }
    keep_settings();
    if (failures_.untold() > 0)
      report_.warn(std::to_string(failures_.untold()) + " more parts could not be read");
    report_.count("frames", frames_);
    report_.quality("renderer", gl_description());
    check_cancelled(progress_);
  }

 private:
  Pilot first_pilot() {
    const SceneBox box = box_of(session_.layers());
    glfwGetFramebufferSize(window_.get(), &width_, &height_);
    pane_width_ = width_;
    return {first_camera(options_, box, double(width_) / std::max(1, height_)),
            std::max(5.0, 0.03 * norm(box.highest - box.lowest)), options_.path};
  }

  void opened(const std::filesystem::path& file) {
    files_.push_back(file);
    settings_.opened(file);
    panels_.recent = settings_.recent;
  }

  void say(std::string message) {
    if (!message.empty()) panels_.message = std::move(message);
  }

  bool is_hidden() {
    glfwGetFramebufferSize(window_.get(), &width_, &height_);
    return glfwGetWindowAttrib(window_.get(), GLFW_ICONIFIED) != GLFW_FALSE || width_ < 1 ||
           height_ < 1;
  }

  /// Looks what has happened; where nothing is to be drawn, once something has or some time later.
  void take_news() {
    const bool hidden = is_hidden();
    if (hidden) pacer_.hide();
    if (pacer_.is_awake() && !hidden)
      glfwPollEvents();
    else
      glfwWaitEventsTimeout(
          pacer_.wait_s(glfwGetTime(), input_.has_pads() ? FramePacer::kFirstFrameS : kLookS));
    ControlInput pads;
    add_pads(pads);
    if (input_.take_news() || asks_to_move(pads)) pacer_.wake();
  }

  void frame(const FramePacer::Frame& paced) {
    const double seconds = paced.seconds;
    if (paced.is_after_pause) {
      session_.pause();
      log_debug("draws again");
    }
    if (!canvas_ || canvas_->drawn.width() != width_ || canvas_->drawn.height() != height_)
      canvas_ = std::make_unique<Canvas>(width_, height_, options_.samples);
    input_.begin_frame(seconds);
    ImGui::NewFrame();
    if (const auto dropped = input_.take_dropped(); !dropped.empty()) open(dropped);
    for (const KeyPress& press : input_.presses()) heed(press);
    const Vec3d before = pilot_.camera().eye;
    const Surroundings around = surroundings();
    say(pilot_.step(read_input(seconds), around));
    const FrameCounts counts = draw(paced, (pilot_.camera().eye - before) / seconds);
    tell_failures();
    glfwSwapBuffers(window_.get());
    ++frames_;
    if (!paced.is_after_pause) {
      panels_.frame_ms[panels_.frame_at] = static_cast<float>(seconds * 1000.0);
      panels_.frame_at = (panels_.frame_at + 1) % panels_.frame_ms.size();
    }
    const bool moves = !counts.is_still || !pilot_.is_at_rest() || input_.has_more();
    // What is missing may still come; text that is entered has a cursor that blinks.
    pacer_.drawn(moves, panels_.shows_frames || !counts.is_settled || ImGui::GetIO().WantTextInput);
    if (!pacer_.is_awake()) log_debug("waits after " + std::to_string(frames_) + " frames");
  }

  void tell_failures() {
    const std::vector<std::string> failures = session_.take_failures();
    if (failures.empty()) return;
    pacer_.wake();
    for (const std::string& failure : failures_.add(failures))
      report_.warn(failure + "; what is coarser is drawn instead");
    panels_.message = failures_.line();
  }

  Split split_of(int width) const {
    if (!session_.can_split()) return {};
    return {panels_.split, panels_.line.share * width};
  }

  FrameCounts draw(const FramePacer::Frame& paced, Vec3d velocity) {
    const Split split = split_of(width_);
    pane_width_ = pane_width(width_, split);
    const FrameCounts counts = session_.draw(canvas_->drawn.framebuffer(), width_, height_,
                                             pilot_.camera(), paced.seconds, velocity, split);
    glBlitNamedFramebuffer(canvas_->drawn.framebuffer(), canvas_->shown.framebuffer(), 0, 0, width_,
                           height_, 0, 0, width_, height_,
                           GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT, GL_NEAREST);
    drawn_camera_ = pilot_.camera();
    if (std::exchange(wants_picture_, false)) say(save_picture());
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glBlitNamedFramebuffer(canvas_->shown.framebuffer(), 0, 0, 0, width_, height_, 0, 0, width_,
                           height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    tell_panels(counts, paced.since_last_s);
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const PanelResult result = draw_panels(
        panels_, session_, pilot_.camera(), static_cast<int>(size.x), static_cast<int>(size.y),
        counts, [this](double x, double y) { return ground_at(x, y); });
    if (result.open) open({*result.open});
    if (result.go) pilot_.go(*result.go);
    ImGui::Render();
    glDisable(GL_DEPTH_TEST);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    return counts;
  }

  void tell_panels(const FrameCounts& counts, double seconds) {
    std::uint64_t read = 0;
    for (const auto& layer : session_.layers()) read += layer->counts().store.bytes_read;
    panels_.uploads.add(double(counts.uploaded_bytes), seconds);
    panels_.reads.add(double(read - read_before_), seconds);
    read_before_ = read;
    panels_.speed_ms = pilot_.speed();
    panels_.walks = pilot_.walks();
    const auto under = under_cursor();
    if (under)
      panels_.depth_m = dot(under->point - drawn_camera_.eye, axes_of(drawn_camera_).forward);
    panels_.read_out = read_out_.text(under);
  }

  /// The ground seen in a pixel of the frame drawn last; nothing for sky.
  std::optional<Vec3d> point_under(double x, double y) const {
    if (!canvas_ || x < 0.0 || y < 0.0 || x >= canvas_->shown.width() ||
        y >= canvas_->shown.height())
      return std::nullopt;
    const float depth = read_depth(canvas_->shown, static_cast<int>(x), static_cast<int>(y));
    return point_of_depth(drawn_camera_, pane_width_, height_, in_pane(x), y, depth);
  }

  /// The column in the one of two pictures that the cursor is in.
  double in_pane(double x) const { return x >= pane_width_ ? x - pane_width_ : x; }

  std::optional<UnderCursor> under_cursor() const {
    const auto here = point_under(cursor_x_, cursor_y_);
    if (!here) return std::nullopt;
    // Beyond the border of two pictures there is other ground.
    const bool is_second = cursor_x_ >= pane_width_;
    return look_under(cursor_x_, cursor_y_, *here, [&](double x, double y) {
      return (x >= pane_width_) == is_second ? point_under(x, y) : std::nullopt;
    });
  }

  std::optional<double> ground_at(double x, double y) {
    std::optional<double> ground;
    for (std::size_t i = 0; i < session_.layers().size(); ++i) {
      if (!session_.looks()[i].is_visible) continue;
      if (const auto z = session_.layers()[i]->ground_at(x, y, pilot_.camera().eye.z + 1.0))
        ground = std::max(ground.value_or(*z), *z);
    }
    return ground;
  }

  Surroundings surroundings() {
    const SceneBox box = box_of(session_.layers());
    return {[this] { return point_under(cursor_x_, cursor_y_); },
            [this](double x, double y) { return ground_at(x, y); }, box.lowest, box.highest,
            double(width_) / height_};
  }

  ControlInput read_input(double seconds) {
    ControlInput in;
    in.seconds = seconds;
    in.width = pane_width_;
    in.height = height_;
    const ImGuiIO& io = ImGui::GetIO();
    const auto [x, y] = input_.pointer();
    in.dx = x - cursor_x_;
    in.dy = y - cursor_y_;
    cursor_x_ = x;
    in.x = in_pane(x);
    in.y = cursor_y_ = y;
    if (!io.WantCaptureMouse && !line_has_mouse()) {
      in.left = io.MouseDown[0];
      in.right = io.MouseDown[1];
      in.middle = io.MouseDown[2];
      in.pressed = ImGui::IsMouseClicked(0) || ImGui::IsMouseClicked(1) || ImGui::IsMouseClicked(2);
      in.is_double_click = input_.is_double_click();
      in.wheel = double(io.MouseWheel);
    }
    if (!io.WantCaptureKeyboard && !io.KeyCtrl) {
      const auto along = [&](int plus, int minus) {
        return double(input_.is_down(plus)) - double(input_.is_down(minus));
      };
      in.fly = {along(GLFW_KEY_W, GLFW_KEY_S), along(GLFW_KEY_D, GLFW_KEY_A),
                along(GLFW_KEY_E, GLFW_KEY_Q)};
      in.is_fast = io.KeyShift;
    }
    in.wheel_is_speed = in.fly.forward != 0.0 || in.fly.right != 0.0 || in.fly.up != 0.0;
    add_pads(in);
    return in;
  }

  void add_pads(ControlInput& in) const {
    const PadMove pads = input_.pads();
    in.fly.forward += pads.fly.forward;
    in.fly.right += pads.fly.right;
    in.fly.up += pads.fly.up;
    in.turn_right += pads.turn_right;
    in.turn_up += pads.turn_up;
    in.is_fast |= pads.is_fast;
  }

  /// True while the mouse is for the line between two pictures.
  bool line_has_mouse() {
    if (split_of(width_).kind != Split::Kind::kSwipe) {
      panels_.line.let_go();
      return false;
    }
    const ImGuiIO& io = ImGui::GetIO();
    const bool has =
        panels_.line.step({double(io.MousePos.x), ImGui::IsMouseClicked(0), io.MouseDown[0],
                           !io.WantCaptureMouse, double(io.DisplaySize.x)});
    if (has) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    return has;
  }

  void heed(const KeyPress& press) {
    const auto asked = action_of(press.key, press.held, ImGui::GetIO().WantCaptureKeyboard);
    if (!asked || heed_window(asked->action)) return;
    auto message = pilot_.heed(asked->action, surroundings(), ".");
    if (!message) message = heed_look(*asked, session_, panels_.split);
    say(message.value_or(""));
  }

  /// Keys of the window and its panels. True where it is one.
  bool heed_window(Action action) {
    switch (action) {
      case Action::kHelp:
        panels_.shows_help = !panels_.shows_help;
        return true;
      case Action::kFrames:
        panels_.shows_frames = !panels_.shows_frames;
        return true;
      case Action::kFullScreen:
        window_.toggle_full_screen();
        return true;
      case Action::kPicture:
        wants_picture_ = true;
        return true;
      case Action::kClosePanels:
        panels_.asks_place = panels_.shows_help = false;
        return true;
      case Action::kQuit:
        glfwSetWindowShouldClose(window_.get(), GLFW_TRUE);
        return true;
      case Action::kGoTo:
        panels_.asks_place = true;
        // What follows was meant for its text, which gets the keyboard in its second frame.
        input_.wait(2);
        return true;
      case Action::kLayers:
        panels_.shows_layers = !panels_.shows_layers;
        return true;
      case Action::kBookmark:
        add_bookmark(panels_.bookmarks, pilot_.camera());
        say("bookmark: " + panels_.bookmarks.back().name);
        return true;
      default:
        return false;
    }
  }

  void open(const std::vector<std::filesystem::path>& files) {
    const Opened result = open_files(session_, files_, files);
    for (const auto& file : result.hierarchies) opened(file);
    say(result.message);
  }

  void keep_settings() {
    const Style& style = session_.style();
    settings_.window = window_.windowed_size();
    settings_.shading = style.shading;
    settings_.contour_interval_m = style.contour_interval_m;
    settings_.has_edges = style.has_edges;
    settings_.error_pixels = session_.error_pixels();
    settings_.frame_ms = session_.frame_ms();
    settings_.shows_layers = panels_.shows_layers;
    settings_.shows_frames = panels_.shows_frames;
    settings_.set_bookmarks(options_.files.front(), panels_.bookmarks);
    const std::filesystem::path file = settings_path();
    if (file.empty()) return;
    try {
      write_settings(file, settings_);
    } catch (const Error& error) {
      report_.warn(std::string("settings are not kept: ") + error.what());
    }
  }

  /// The view at several times the window's size, with all that it needs at that size.
  Picture large_picture(int scale) {
    constexpr int kMost = 16384;
    scale = std::max(1, std::min(kMost / std::max(width_, height_), scale));
    const Canvas canvas(scale * width_, scale * height_, options_.samples);
    session_.draw(canvas.drawn.framebuffer(), canvas.drawn.width(), canvas.drawn.height(),
                  drawn_camera_, 0.0, {}, split_of(canvas.drawn.width()));
    resolve(canvas.drawn, canvas.shown);
    return read_picture(canvas.shown);
  }

  /// Returns what to say.
  std::string save_picture() {
    try {
      const Picture picture = panels_.picture_scale > 1 ? large_picture(panels_.picture_scale)
                                                        : read_picture(canvas_->shown);
      const std::string name = unused_stem(".", "cornice-" + time_stamp(), {".png", ".json"});
      write_picture(name + ".png", picture);
      write_camera(name + ".json", drawn_camera_);
      return "picture written: " + name + ".png";
    } catch (const Error& error) {
      return error.what();
    } catch (const std::bad_alloc&) {
      return "the picture needs more memory than there is; make it smaller in the panel of layers";
    }
  }

  /// Between looks at whether the process is told to end or the window is seen again.
  static constexpr double kLookS = 0.1;

  const Options& options_;
  Report& report_;
  Progress& progress_;
  Settings settings_;
  WindowSystem& window_;
  Session session_;
  std::unique_ptr<Canvas> canvas_;
  ReadOut read_out_;
  int width_ = 0, height_ = 0, pane_width_ = 0;
  Pilot pilot_;        ///< after the sizes that it starts with
  WindowInput input_;  ///< after all that fails on a file that is no good
  FramePacer pacer_;
  Camera drawn_camera_;
  PanelState panels_;
  FailureLog failures_;
  std::vector<std::filesystem::path> files_;  ///< of the layers
  double cursor_x_ = 0.0, cursor_y_ = 0.0;
  bool wants_picture_ = false;
  std::uint64_t frames_ = 0;
  std::uint64_t read_before_ = 0;  ///< bytes from the disk before this frame
};

/// The latest of the settings' files that is still there.
std::vector<std::filesystem::path> latest_file(const Settings& settings) {
  for (const auto& file : settings.recent) {
    std::error_code error;
    if (std::filesystem::exists(file, error)) return {file};
  }
  return {};
}

}  // namespace

void run_window(const Options& asked, SettingsRead settings, Report& report, Progress& progress) {
  Options options = asked;
  if (!settings.problem.empty()) report.warn(settings.problem);
  WindowSystem window(parse_size(options.size));
  std::string problem;
  if (asked.files.empty()) options.files = latest_file(settings.settings);
  for (;;) {
    if (options.files.empty()) options.files = ask_for_files(window, progress, problem);
    check_cancelled(progress);
    if (options.files.empty()) return;
    try {
      WindowApp app(options, settings, window, report, progress);
      for (const auto& file : options.files) report.add_input(file);
      return app.run();
    } catch (const InputError& error) {
      // Files that nobody named on the command line may be damaged: another one will do.
      if (!asked.files.empty()) throw;
      problem = error.what();
      options.files.clear();
    }
  }
}

}  // namespace cornice::viewer
