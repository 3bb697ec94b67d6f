// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/window.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "terrain-viewer/app/camera_memory.h"
#include "terrain-viewer/app/controls.h"
#include "terrain-viewer/app/input_queue.h"
#include "terrain-viewer/app/panels.h"
#include "terrain-viewer/app/pick.h"
#include "terrain-viewer/app/picture.h"
#include "terrain-viewer/app/session.h"
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

class WindowApp {
 public:
  WindowApp(const Options& options, SettingsRead settings, Report& report, Progress& progress)
      : options_(options),
        report_(report),
        progress_(progress),
        settings_(std::move(settings.settings)),
        window_(parse_size(options.size)),
        session_(options) {
    if (auto second = window_.second()) session_.make_room_ahead(std::move(second));
    panels_.message = settings.problem;
    panels_.shows_layers = settings_.shows_layers;
    panels_.shows_frames = settings_.shows_frames;
    if (options.side_by_side) panels_.split = Split::Kind::kSideBySide;
    for (const auto& file : options.files) settings_.opened(file);
    panels_.recent = settings_.recent;
    panels_.bookmarks = settings_.bookmarks_of(options.files.front());
    const SceneBox box = box_of(session_.layers());
    glfwGetFramebufferSize(window_.get(), &width_, &height_);
    pane_width_ = width_;
    camera_ = options.camera.empty()
                  ? seeing_all({}, box.lowest, box.highest, double(width_) / std::max(1, height_))
                  : read_camera(options.camera);
    controls_.speed_ms = std::max(5.0, 0.03 * norm(box.highest - box.lowest));
    moves_.jump(camera_);
    glfwSetWindowUserPointer(window_.get(), this);
    glfwSetDropCallback(window_.get(), [](GLFWwindow* window, int count, const char** paths) {
      for (int i = 0; i < count; ++i) of(window).open_file(paths[i]);
    });
    listen();
  }

  void run() {
    auto last = std::chrono::steady_clock::now();
    while (glfwWindowShouldClose(window_.get()) == GLFW_FALSE && !progress_.cancelled()) {
      glfwPollEvents();
      const auto now = std::chrono::steady_clock::now();
      const double seconds =
          std::clamp(std::chrono::duration<double>(now - last).count(), 1e-4, 0.25);
      last = now;
      frame(seconds);
      panels_.frame_ms[panels_.frame_at] = static_cast<float>(seconds * 1000.0);
      panels_.frame_at = (panels_.frame_at + 1) % panels_.frame_ms.size();
      ++frames_;
    }
    keep_settings();
    report_.count("frames", frames_);
    report_.quality("renderer", gl_description());
    check_cancelled(progress_);
  }

 private:
  /// A key that went down, and the GLFW_MOD_ bits of those held then.
  struct KeyPress {
    int key = 0, held = 0;
  };

  static WindowApp& of(GLFWwindow* window) {
    return *static_cast<WindowApp*>(glfwGetWindowUserPointer(window));
  }

  /// Puts what happens into the queue, in place of ImGui, which gets it from there.
  void listen() {
    glfwSetKeyCallback(
        window_.get(), [](GLFWwindow* window, int key, int scancode, int action, int held) {
          if (action == GLFW_REPEAT) return;
          const bool is_modifier = key >= GLFW_KEY_LEFT_SHIFT && key <= GLFW_KEY_RIGHT_SUPER;
          const bool is_letter = key < GLFW_KEY_ESCAPE && (held & GLFW_MOD_CONTROL) == 0;
          of(window).happened({.kind = InputEvent::Kind::kKey,
                               .code = key,
                               .scancode = scancode,
                               .held = held,
                               .is_down = action == GLFW_PRESS,
                               .is_modifier = is_modifier,
                               .is_letter = is_letter});
        });
    glfwSetCharCallback(window_.get(), [](GLFWwindow* window, unsigned int character) {
      of(window).happened(
          {.kind = InputEvent::Kind::kCharacter, .code = static_cast<int>(character)});
    });
    glfwSetMouseButtonCallback(window_.get(),
                               [](GLFWwindow* window, int button, int action, int held) {
                                 if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
                                 InputEvent event{.kind = InputEvent::Kind::kButton,
                                                  .code = button,
                                                  .held = held,
                                                  .is_down = action == GLFW_PRESS};
                                 glfwGetCursorPos(window, &event.x, &event.y);
                                 of(window).happened(event);
                               });
    glfwSetScrollCallback(window_.get(), [](GLFWwindow* window, double x, double y) {
      of(window).happened({.kind = InputEvent::Kind::kWheel, .x = x, .y = y});
    });
    // ImGui has none of its own before 1.87.
    move_of_imgui_ =
        glfwSetCursorPosCallback(window_.get(), [](GLFWwindow* window, double x, double y) {
          of(window).happened({.kind = InputEvent::Kind::kMove, .x = x, .y = y});
        });
    glfwGetCursorPos(window_.get(), &pointer_[0], &pointer_[1]);
  }

  void happened(InputEvent event) {
    event.time_s = glfwGetTime();
    events_.add(event, frame_s_);
  }

  /// Tells ImGui, and this program, what this frame is to know.
  void take_events() {
    is_double_click_ = false;
    if (waiting_frames_ > 0) {
      --waiting_frames_;
      return;
    }
    for (const InputEvent& event : events_.take(ImGui::GetIO().WantTextInput)) {
      const int action = event.is_down ? GLFW_PRESS : GLFW_RELEASE;
      switch (event.kind) {
        case InputEvent::Kind::kKey:
          ImGui_ImplGlfw_KeyCallback(window_.get(), event.code, event.scancode, action, event.held);
          if (event.is_down) presses_.push_back({event.code, event.held});
          break;
        case InputEvent::Kind::kCharacter:
          ImGui_ImplGlfw_CharCallback(window_.get(), static_cast<unsigned int>(event.code));
          break;
        case InputEvent::Kind::kButton:
          ImGui_ImplGlfw_MouseButtonCallback(window_.get(), event.code, action, event.held);
          buttons_[static_cast<std::size_t>(event.code)] = event.is_down;
          is_double_click_ |= event.is_second && event.code == GLFW_MOUSE_BUTTON_LEFT;
          pointer_ = {event.x, event.y};
          break;
        case InputEvent::Kind::kWheel:
          ImGui_ImplGlfw_ScrollCallback(window_.get(), event.x, event.y);
          break;
        case InputEvent::Kind::kMove:
          if (move_of_imgui_ != nullptr) move_of_imgui_(window_.get(), event.x, event.y);
          pointer_ = {event.x, event.y};
      }
    }
  }

  /// ImGui before 1.87 asks GLFW where the mouse is now, which may be ahead of the queue.
  void place_pointer() {
    ImGuiIO& io = ImGui::GetIO();
    if (io.MousePos.x >= 0.0f) io.MousePos = {float(pointer_[0]), float(pointer_[1])};
    std::copy(buttons_.begin(), buttons_.end(), std::begin(io.MouseDown));
  }

  void frame(double seconds) {
    glfwGetFramebufferSize(window_.get(), &width_, &height_);
    if (width_ < 1 || height_ < 1) return;
    if (!canvas_ || canvas_->drawn.width() != width_ || canvas_->drawn.height() != height_)
      canvas_ = std::make_unique<Canvas>(width_, height_, options_.samples);
    frame_s_ = seconds;
    take_events();
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    place_pointer();
    ImGui::NewFrame();
    const Vec3d before = camera_.eye;
    read_keys();
    if (path_.is_playing()) camera_ = path_.play(seconds);
    camera_ = controls_.step(
        camera_, read_input(seconds), [this] { return point_under(cursor_x_, cursor_y_); },
        [this](double x, double y) { return ground_at(x, y); });
    moves_.see(camera_);
    const Vec3d velocity = (camera_.eye - before) / seconds;
    draw(seconds, velocity);
    for (const std::string& failure : session_.take_failures()) {
      panels_.message = failure;
      report_.warn(failure + "; its parent is drawn instead");
    }
    glfwSwapBuffers(window_.get());
  }

  void draw(double seconds, Vec3d velocity) {
    Split split{panels_.split, panels_.swipe * width_};
    if (!session_.can_split()) split = {};
    pane_width_ = pane_width(width_, split);
    const FrameCounts counts = session_.draw(canvas_->drawn.framebuffer(), width_, height_, camera_,
                                             seconds, velocity, split);
    glBlitNamedFramebuffer(canvas_->drawn.framebuffer(), canvas_->shown.framebuffer(), 0, 0, width_,
                           height_, 0, 0, width_, height_,
                           GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT, GL_NEAREST);
    drawn_camera_ = camera_;
    if (wants_picture_) save_picture();
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glBlitNamedFramebuffer(canvas_->shown.framebuffer(), 0, 0, 0, width_, height_, 0, 0, width_,
                           height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    panels_.speed_ms = controls_.speed_ms;
    tell_rates(counts, seconds);
    panels_.walks = controls_.walks;
    const PanelResult result =
        draw_panels(panels_, session_, camera_, width_, height_, under_cursor(), counts,
                    [this](double x, double y) { return ground_at(x, y); });
    if (result.open) open_file(result.open->c_str());
    if (result.go) {
      moves_.jump(camera_);
      camera_ = *result.go;
      moves_.jump(camera_);
    }
    ImGui::Render();
    glDisable(GL_DEPTH_TEST);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  }

  void tell_rates(const FrameCounts& counts, double seconds) {
    std::uint64_t read = 0;
    for (const auto& layer : session_.layers()) read += layer->counts().store.bytes_read;
    panels_.uploads.add(double(counts.uploaded_bytes), seconds);
    panels_.reads.add(double(read - read_before_), seconds);
    read_before_ = read;
  }

  /// The ground seen in a pixel of the frame drawn last; nothing for sky.
  std::optional<Vec3d> point_under(double x, double y) const {
    if (!canvas_ || x < 0.0 || y < 0.0 || x >= width_ || y >= height_) return std::nullopt;
    const float depth = read_depth(canvas_->shown, static_cast<int>(x), static_cast<int>(y));
    return point_of_depth(drawn_camera_, pane_width_, height_, in_pane(x), y, depth);
  }

  /// The column in the one of two pictures that the cursor is in.
  double in_pane(double x) const { return x >= pane_width_ ? x - pane_width_ : x; }

  std::optional<UnderCursor> under_cursor() const {
    const auto here = point_under(cursor_x_, cursor_y_);
    if (!here) return std::nullopt;
    return look_under(cursor_x_, cursor_y_, *here,
                      [this](double x, double y) { return point_under(x, y); });
  }

  std::optional<double> ground_at(double x, double y) {
    std::optional<double> ground;
    for (std::size_t i = 0; i < session_.layers().size(); ++i) {
      if (!session_.looks()[i].is_visible) continue;
      if (const auto z = session_.layers()[i]->ground_at(x, y, camera_.eye.z + 1.0))
        ground = std::max(ground.value_or(*z), *z);
    }
    return ground;
  }

  bool is_down(int key) const { return glfwGetKey(window_.get(), key) == GLFW_PRESS; }

  ControlInput read_input(double seconds) {
    ControlInput in;
    in.seconds = seconds;
    in.width = pane_width_;
    in.height = height_;
    const ImGuiIO& io = ImGui::GetIO();
    // The cursor is in screen units, which are not pixels on every display.
    const double x = pointer_[0] * double(io.DisplayFramebufferScale.x);
    const double y = pointer_[1] * double(io.DisplayFramebufferScale.y);
    in.dx = x - cursor_x_;
    in.dy = y - cursor_y_;
    cursor_x_ = x;
    in.x = in_pane(x);
    in.y = cursor_y_ = y;
    if (!io.WantCaptureMouse) {
      in.left = io.MouseDown[0];
      in.right = io.MouseDown[1];
      in.middle = io.MouseDown[2];
      in.pressed = ImGui::IsMouseClicked(0) || ImGui::IsMouseClicked(1) || ImGui::IsMouseClicked(2);
      in.is_double_click = is_double_click_;
      in.wheel = double(io.MouseWheel);
    }
    if (!io.WantCaptureKeyboard && !io.KeyCtrl) {
      const auto along = [&](int plus, int minus) {
        return double(is_down(plus)) - double(is_down(minus));
      };
      in.fly = {along(GLFW_KEY_W, GLFW_KEY_S), along(GLFW_KEY_D, GLFW_KEY_A),
                along(GLFW_KEY_E, GLFW_KEY_Q)};
      in.is_fast = io.KeyShift;
    }
    in.wheel_is_speed = in.fly.forward != 0.0 || in.fly.right != 0.0 || in.fly.up != 0.0;
    read_gamepad(in);
    return in;
  }

  static void read_gamepad(ControlInput& in) {
    GLFWgamepadstate pad{};
    if (glfwGetGamepadState(GLFW_JOYSTICK_1, &pad) != GLFW_TRUE) return;
    const auto axis = [&](int which) {
      const double value = double(pad.axes[which]);
      return std::abs(value) < 0.15 ? 0.0 : value;
    };
    in.fly.right += axis(GLFW_GAMEPAD_AXIS_LEFT_X);
    in.fly.forward -= axis(GLFW_GAMEPAD_AXIS_LEFT_Y);
    in.fly.up +=
        0.5 * (axis(GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER) - axis(GLFW_GAMEPAD_AXIS_LEFT_TRIGGER));
    in.turn_right += axis(GLFW_GAMEPAD_AXIS_RIGHT_X);
    in.turn_up -= axis(GLFW_GAMEPAD_AXIS_RIGHT_Y);
    in.is_fast |= pad.buttons[GLFW_GAMEPAD_BUTTON_A] == GLFW_PRESS;
  }

  void read_keys() {
    for (const KeyPress press : std::exchange(presses_, {})) {
      if (heed_always(press.key)) continue;
      if (ImGui::GetIO().WantCaptureKeyboard) continue;
      if ((press.held & GLFW_MOD_CONTROL) != 0)
        heed_with_control(press.key);
      else if (!heed_move(press))
        heed_look(press.key);
    }
  }

  /// Keys that count while text is entered, too. True where it is one.
  bool heed_always(int key) {
    switch (key) {
      case GLFW_KEY_F1:
        panels_.shows_help = !panels_.shows_help;
        return true;
      case GLFW_KEY_F3:
        panels_.shows_frames = !panels_.shows_frames;
        return true;
      case GLFW_KEY_F11:
        toggle_full_screen();
        return true;
      case GLFW_KEY_F12:
        wants_picture_ = true;
        return true;
      case GLFW_KEY_ESCAPE:
        panels_.asks_place = panels_.shows_help = false;
        return true;
      default:
        return false;
    }
  }

  void heed_with_control(int key) {
    if (key == GLFW_KEY_Z) camera_ = moves_.undo(camera_);
    if (key == GLFW_KEY_Y) camera_ = moves_.redo(camera_);
    if (key == GLFW_KEY_P) start_playing();
    if (key == GLFW_KEY_Q) glfwSetWindowShouldClose(window_.get(), GLFW_TRUE);
  }

  /// Keys of the camera and of panels. True where it is one.
  bool heed_move(KeyPress press) {
    switch (press.key) {
      case GLFW_KEY_G:
        panels_.asks_place = true;
        // What follows was meant for its text, which gets the keyboard in its second frame.
        waiting_frames_ = 2;
        return true;
      case GLFW_KEY_L:
        panels_.shows_layers = !panels_.shows_layers;
        return true;
      case GLFW_KEY_SPACE:
        controls_.walks = !controls_.walks;
        return true;
      case GLFW_KEY_HOME:
        see_all();
        return true;
      case GLFW_KEY_B:
        add_bookmark(panels_.bookmarks, camera_);
        return true;
      case GLFW_KEY_P:
        (press.held & GLFW_MOD_SHIFT) != 0 ? save_path() : add_path_key();
        return true;
      default:
        return false;
    }
  }

  void heed_look(int key) {
    Style& style = session_.style();
    if (key == GLFW_KEY_N)
      style.shading = static_cast<Shading>((static_cast<std::size_t>(style.shading) + 1) %
                                           kShadingNames.size());
    if (key == GLFW_KEY_C) style.contour_interval_m = style.contour_interval_m > 0.0 ? 0.0 : 20.0;
    if (key == GLFW_KEY_X) style.has_edges = !style.has_edges;
    if (key == GLFW_KEY_O) next_cover();
    if (key == GLFW_KEY_V) next_split();
    if (key == GLFW_KEY_K) session_.is_frozen() = !session_.is_frozen();
    auto& looks = session_.looks();
    if (const int i = key - GLFW_KEY_1; i >= 0 && i < std::min(9, static_cast<int>(looks.size())))
      looks[static_cast<std::size_t>(i)].is_visible =
          !looks[static_cast<std::size_t>(i)].is_visible;
    if (key == GLFW_KEY_TAB) session_.blink();
  }

  void next_split() {
    if (session_.can_split())
      panels_.split = static_cast<Split::Kind>((static_cast<int>(panels_.split) + 1) % 3);
    else
      panels_.message = "two pictures need two visible layers, or a raster over one";
  }

  void next_cover() {
    const bool has_difference = session_.difference() != nullptr;
    switch (session_.cover()) {
      case Cover::kNone:
        session_.set_cover(session_.photo() != nullptr ? Cover::kPhoto : Cover::kDifference);
        break;
      case Cover::kPhoto:
        session_.set_cover(has_difference ? Cover::kDifference : Cover::kNone);
        break;
      case Cover::kDifference:
        session_.set_cover(Cover::kNone);
    }
  }

  void see_all() {
    const SceneBox box = box_of(session_.layers());
    camera_ = seeing_all(camera_, box.lowest, box.highest, double(width_) / height_);
  }

  void add_path_key() {
    path_.add(camera_);
    panels_.message = std::to_string(path_.size()) + " views in the path; Shift+P saves it";
  }

  /// The path that is being made, else the one of --path, from its start.
  void start_playing() {
    try {
      if (path_.size() == 0 && !options_.path.empty()) path_.set(read_camera_path(options_.path));
    } catch (const Error& error) {
      panels_.message = error.what();
    }
    path_.toggle_play();
  }

  void keep_settings() {
    const Style& style = session_.style();
    if (glfwGetWindowMonitor(window_.get()) == nullptr)
      glfwGetWindowSize(window_.get(), &settings_.window.width, &settings_.window.height);
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

  void save_path() {
    if (path_.size() == 0) return;
    const std::string name = "cornice-path-" + stamp() + ".json";
    write_camera_path(name, path_.path());
    panels_.message = "path written: " + name;
    path_.clear();
  }

  /// The view at several times the window's size, with all that it needs at that size.
  Picture large_picture(int scale) {
    constexpr int kMost = 16384;
    scale = std::clamp(kMost / std::max(width_, height_), 1, scale);
    const Canvas canvas(scale * width_, scale * height_, options_.samples);
    Split split{panels_.split, panels_.swipe * canvas.drawn.width()};
    if (!session_.can_split()) split = {};
    session_.draw(canvas.drawn.framebuffer(), canvas.drawn.width(), canvas.drawn.height(),
                  drawn_camera_, 0.0, {}, split);
    resolve(canvas.drawn, canvas.shown);
    return read_picture(canvas.shown);
  }

  void save_picture() {
    wants_picture_ = false;
    const std::string name = "cornice-" + stamp();
    try {
      write_picture(name + ".png", panels_.picture_scale > 1 ? large_picture(panels_.picture_scale)
                                                             : read_picture(canvas_->shown));
      write_camera(name + ".json", drawn_camera_);
      panels_.message = "picture written: " + name + ".png";
    } catch (const Error& error) {
      panels_.message = error.what();
    }
  }

  static std::string stamp() {
    const std::time_t now = std::time(nullptr);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y%m%d-%H%M%S", std::localtime(&now));
    return text.data();
  }

  void open_file(const char* path) {
    try {
      const std::string ending = std::filesystem::path(path).extension().string();
      const auto kind = ending == ".hlod" ? std::nullopt : raster_kind(path);
      if (kind)
        session_.add_drape({path}, *kind);
      else
        session_.add_layer(path);
      if (!kind) {
        settings_.opened(path);
        panels_.recent = settings_.recent;
      }
      panels_.message = std::string("opened ") + path;
    } catch (const Error& error) {
      panels_.message = error.what();
    }
  }

  void toggle_full_screen() {
    if (glfwGetWindowMonitor(window_.get()) != nullptr) {
      glfwSetWindowMonitor(window_.get(), nullptr, 60, 60, windowed_width_, windowed_height_, 0);
      return;
    }
    GLFWmonitor* monitor = glfwGetPrimaryMonitor();
    if (monitor == nullptr) return;
    glfwGetWindowSize(window_.get(), &windowed_width_, &windowed_height_);
    const GLFWvidmode* mode = glfwGetVideoMode(monitor);
    glfwSetWindowMonitor(window_.get(), monitor, 0, 0, mode->width, mode->height,
                         mode->refreshRate);
  }

  const Options& options_;
  Report& report_;
  Progress& progress_;
  Settings settings_;
  WindowSystem window_;
  Session session_;
  std::unique_ptr<Canvas> canvas_;
  Controls controls_;
  CameraMoves moves_;
  PanelState panels_;
  PathMaker path_;
  Camera camera_, drawn_camera_;
  int width_ = 0, height_ = 0, windowed_width_ = 1280, windowed_height_ = 720;
  double cursor_x_ = 0.0, cursor_y_ = 0.0;
  bool wants_picture_ = false;
  int pane_width_ = 0;
  InputQueue events_;
  std::array<double, 2> pointer_{};  ///< the cursor as this frame knows it, screen units
  std::array<bool, 3> buttons_{};    ///< left, right, middle
  bool is_double_click_ = false;
  int waiting_frames_ = 0;  ///< in which no event is taken
  double frame_s_ = 0.0;
  GLFWcursorposfun move_of_imgui_ = nullptr;
  std::vector<KeyPress> presses_;  ///< of this frame
  std::uint64_t frames_ = 0;
  std::uint64_t read_before_ = 0;  ///< bytes from the disk before this frame
};

}  // namespace

void run_window(const Options& asked, SettingsRead settings, Report& report, Progress& progress) {
  Options options = asked;
  if (options.files.empty()) {
    if (settings.settings.recent.empty())
      throw UsageError("FILE", "is missing: which hierarchies to look at, .hlod");
    options.files = {settings.settings.recent.front()};
  }
  if (!settings.problem.empty()) report.warn(settings.problem);
  for (const auto& file : options.files) report.add_input(file);
  WindowApp app(options, std::move(settings), report, progress);
  app.run();
}

}  // namespace cornice::viewer
