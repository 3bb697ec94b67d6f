// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-viewer without a window, on a hierarchy that cornice-hlod builds of ground with an
// overhang.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/ply.h"
#include "terrain-viewer/scene/camera_file.h"
#include "terrain-viewer/scene/ramp.h"
#include "tests/support/full_disk.h"
#include "tests/support/json_file.h"
#include "tests/support/meshes.h"
#include "tests/support/picture.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice::viewer {
namespace {

using test::ProcessResult;
using test::run_process;

const std::string kHlod = CORNICE_BIN_DIR "/cornice-hlod";
const std::string kViewer = CORNICE_BIN_DIR "/cornice-viewer";
constexpr double kWest = 2600000.0, kSouth = 1200000.0;

double height(double x, double y) {
  return 60.0 * std::exp(-0.0004 * ((x - 130.0) * (x - 130.0) + (y - 90.0) * (y - 90.0))) +
         6.0 * std::sin(0.08 * x) * std::cos(0.05 * y) + 0.8 * std::sin(0.9 * x + 0.7 * y);
}

/// One hierarchy of 260 m of hills for all tests.
class Viewer : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TemporaryFolder;
    Mesh mesh = test::height_mesh(0.0, 0.0, 520, 0.5, height);
    mesh.origin = {kWest, kSouth, 1800.0};
    mesh.crs_text = "EPSG:2056+5728";
    write_ply(*folder_ / "hills.ply", mesh);
    const ProcessResult built =
        run_process({kHlod, "build", *folder_ / "hills.ply", "-o", *folder_ / "hills.hlod",
                     "--triangles-per-cell", "4000", "--no-progress"});
    ASSERT_EQ(built.exit_code, 0) << built.err;
  }
  static void TearDownTestSuite() { delete folder_; }

  static ProcessResult view(std::vector<std::string> more, const std::string& file = "hills.hlod") {
    std::vector<std::string> arguments{kViewer, *folder_ / file, "--headless", "--no-progress"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_process(arguments);
  }
  static std::string at(const std::string& name) { return (*folder_ / name).string(); }

  static Camera above_hills(double x, double y, double up, double heading, double pitch) {
    Camera camera;
    camera.eye = {kWest + x, kSouth + y, 1800.0 + height(x, y) + up};
    camera.heading_deg = heading;
    camera.pitch_deg = pitch;
    camera.field_of_view_deg = 50.0;
    return camera;
  }

  static inline test::TemporaryFolder* folder_ = nullptr;
};

TEST_F(Viewer, DrawsAllThereIsWhereNoCameraIsGiven) {
  const ProcessResult drawn =
      view({"-o", at("all.png"), "--size", "320x200", "--no-sky", "--shading", "plain"});
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  const Picture picture = test::read_png(at("all.png"));
  ASSERT_EQ(picture.width, 320);
  ASSERT_EQ(picture.height, 200);
  const std::size_t black = test::count_of(picture, {0, 0, 0});
  EXPECT_GT(black, 64000u / 10) << "the ground does not fill the picture";
  EXPECT_LT(black, 64000u * 9 / 10) << "the ground is in the picture";
  for (const int x : {0, 319})
    for (const int y : {0, 199})
      EXPECT_EQ(picture.pixels[static_cast<std::size_t>(y * 320 + x)],
                (std::array<std::uint8_t, 3>{0, 0, 0}));
}

TEST_F(Viewer, SaysInThePictureWhatTheColoursMeanWhereAskedTo) {
  const auto draw = [&](const std::string& name, std::vector<std::string> more) {
    more.insert(more.end(), {"-o", at(name), "--size", "400x300", "--shading", "slope"});
    EXPECT_EQ(view(more).exit_code, 0);
    return test::read_png(at(name));
  };
  const Picture with = draw("with.png", {"--legend"}), without = draw("without.png", {});
  const Ramp ramp = slope_ramp();
  const auto shows_ramp = [&](const Picture& picture, int x) {
    std::size_t next = 0;
    for (int y = picture.height - 1; y >= 0 && next + 1 < ramp.stops.size(); --y)
      if (picture.pixels[static_cast<std::size_t>(y * picture.width + x)] ==
          ramp.stops[next].colour)
        ++next;
    return next + 1 == ramp.stops.size();
  };
  int shown = 0, elsewhere = 0;
  for (int x = 0; x < 400; ++x) {
    shown += shows_ramp(with, x) ? 1 : 0;
    elsewhere += shows_ramp(without, x) ? 1 : 0;
    if (x >= 250) continue;
    for (int y = 0; y < 300; ++y) {
      const auto pixel = static_cast<std::size_t>(y * 400 + x);
      ASSERT_EQ(with.pixels[pixel], without.pixels[pixel]) << "only the legend's corner changes";
    }
  }
  EXPECT_GE(shown, 15);
  EXPECT_EQ(elsewhere, 0);
}

TEST_F(Viewer, FindsViewsOfItsOwn) {
  for (const char* from : {"overview", "steepest"}) {
    const std::string name = std::string(from) + ".png";
    const ProcessResult drawn = view(
        {"-o", at(name), "--view", from, "--size", "320x200", "--no-sky", "--shading", "plain"});
    ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
    const Picture picture = test::read_png(at(name));
    const std::size_t black = test::count_of(picture, {0, 0, 0});
    EXPECT_LT(black, 64000u * 2 / 3) << from << ": the ground fills a third and more";
    // The middle of the picture is ground.
    EXPECT_NE(picture.pixels[320 * 100 + 160], (std::array<std::uint8_t, 3>{0, 0, 0})) << from;
  }
  EXPECT_EQ(view({"-o", at("x.png"), "--view", "below"}).exit_code, 2);
}

TEST_F(Viewer, DrawsTheSamePictureFromTheCameraThatItSaved) {
  const auto draw = [&](const std::string& name, std::vector<std::string> more) {
    more.insert(more.end(), {"-o", at(name), "--view", "steepest", "--size", "320x200"});
    const ProcessResult drawn = view(more);
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    return test::read_text(at(name));
  };
  const std::string found = draw("found.png", {"--save-camera", at("found.json")});
  EXPECT_EQ(draw("again.png", {"--camera", at("found.json")}), found) << "camera or light differ";
  Camera camera = read_camera(at("found.json"));
  camera.heading_deg += 2.0;
  write_camera(at("turned.json"), camera);
  EXPECT_NE(draw("turned.png", {"--camera", at("turned.json")}), found);
}

TEST_F(Viewer, ShowsNoCrackInAFlightThroughLevelsThatAreStillBeingLoaded) {
  CameraPath path;
  path.frames_per_second = 15.0;
  for (int key = 0; key < 5; ++key)
    path.keys.push_back({1.0 * key, above_hills(60.0 + 35.0 * key, 120.0 - 12.0 * key,
                                                4.0 + 9.0 * (key % 2), 20.0 * key, -75.0)});
  write_camera_path(at("flight.json"), path);
  const ProcessResult drawn =
      view({"-o", at("f_%03d.png"), "--path", at("flight.json"), "--size", "160x120", "--no-sky",
            "--shading", "level", "--stream", "--error-pixels", "4", "--samples", "1"});
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  for (int frame = 0; frame <= 60; ++frame) {
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "f_%03d.png", frame);
    const Picture picture = test::read_png(at(name.data()));
    ASSERT_EQ(test::count_of(picture, {0, 0, 0}), 0u) << "a hole in " << name.data();
  }
}

TEST_F(Viewer, DrawsWithFewTrianglesAlmostWhatTheFinestMeshLooksLike) {
  write_camera(at("valley.json"), above_hills(40.0, 30.0, 12.0, 45.0, -12.0));
  const auto draw = [&](const std::string& name, const std::string& pixels) {
    const ProcessResult drawn =
        view({"-o", at(name), "--camera", at("valley.json"), "--size", "480x320", "--error-pixels",
              pixels, "--report", at(name + ".json")});
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    std::ifstream report(at(name + ".json"));
    return nlohmann::json::parse(report)["quality"]["triangles, median"].get<double>();
  };
  const double finest = draw("finest.png", "0.1");
  const double chosen = draw("chosen.png", "2");
  EXPECT_LT(chosen, 0.6 * finest);
  const test::PictureDifference difference =
      test::compare_pictures(test::read_png(at("finest.png")), test::read_png(at("chosen.png")));
  EXPECT_LE(difference.mean, 3.0);
  EXPECT_GE(difference.share_within(16), 0.95);
}

TEST_F(Viewer, WritesTheSamePictureEachTime) {
  for (const char* name : {"one.png", "two.png"})
    ASSERT_EQ(view({"-o", at(name), "--size", "200x150", "--contours-m", "5"}).exit_code, 0);
  EXPECT_EQ(test::read_text(at("one.png")), test::read_text(at("two.png")));
}

TEST_F(Viewer, NumbersTheFramesOfAFilmEachThePictureOfItsCameraHoweverCellsAreLoaded) {
  CameraPath path;
  path.frames_per_second = 2.0;
  path.keys = {{1.0, above_hills(60.0, 150.0, 20.0, 0.0, -40.0)},
               {2.0, above_hills(120.0, 100.0, 6.0, 70.0, -60.0)},
               {3.0, above_hills(200.0, 80.0, 40.0, 140.0, -80.0)}};
  write_camera_path(at("film.json"), path);
  const std::vector<std::string> look{"--size", "160x120", "--error-pixels", "1"};
  const auto film = [&](const std::string& names, const std::string& threads) {
    std::vector<std::string> words{
        "-o", at(names), "--path", at("film.json"), "--loading-threads", threads};
    words.insert(words.end(), look.begin(), look.end());
    const ProcessResult drawn = view(words);
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
  };
  film("one_%d.png", "1");
  film("four_%03d.png", "4");
  for (int frame = 0; frame < 5; ++frame) {
    const std::string number = std::to_string(frame);
    const std::string drawn = test::read_text(at("one_" + number + ".png"));
    EXPECT_EQ(drawn, test::read_text(at("four_00" + number + ".png"))) << frame;
    if (frame != 1 && frame != 3) continue;
    write_camera(at("still.json"), path.at(1.0 + 0.5 * frame));
    std::vector<std::string> words{"-o", at("still.png"), "--overwrite", "--camera",
                                   at("still.json")};
    words.insert(words.end(), look.begin(), look.end());
    ASSERT_EQ(view(words).exit_code, 0);
    EXPECT_EQ(drawn, test::read_text(at("still.png"))) << "the film remembers, frame " << frame;
  }
  EXPECT_FALSE(std::filesystem::exists(at("one_5.png")));
  path.keys.resize(1);
  write_camera_path(at("film.json"), path);
  film("single_%d.png", "1");
  EXPECT_TRUE(std::filesystem::exists(at("single_0.png")));
  EXPECT_FALSE(std::filesystem::exists(at("single_1.png")));
}

TEST_F(Viewer, DrawsTheSameViewInALargerPicture) {
  write_camera(at("larger.json"), above_hills(40.0, 30.0, 30.0, 45.0, -25.0));
  const auto draw = [&](const std::string& name, const std::string& size) {
    EXPECT_EQ(view({"-o", at(name), "--size", size, "--camera", at("larger.json"), "--shading",
                    "plain", "--error-pixels", "0.1"})
                  .exit_code,
              0);
    return test::read_png(at(name));
  };
  const Picture small = draw("less.png", "240x160"), large = draw("more.png", "720x480");
  Picture reduced{240, 160, {}};
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 240; ++x) {
      std::array<int, 3> sum{4, 4, 4};
      for (int i = 0; i < 9; ++i)
        for (std::size_t c = 0; c < 3; ++c)
          sum[c] +=
              large.pixels[static_cast<std::size_t>((3 * y + i / 3) * 720 + 3 * x + i % 3)][c];
      reduced.pixels.push_back({static_cast<std::uint8_t>(sum[0] / 9),
                                static_cast<std::uint8_t>(sum[1] / 9),
                                static_cast<std::uint8_t>(sum[2] / 9)});
    }
  const test::PictureDifference difference = test::compare_pictures(small, reduced);
  EXPECT_LE(difference.mean, 1.5);
  EXPECT_GE(difference.share_within(24), 0.98);
}

TEST_F(Viewer, LeavesWholePicturesAloneWhereAFilmIsStopped) {
  CameraPath path;
  path.frames_per_second = 100.0;
  path.keys = {{0.0, above_hills(60.0, 150.0, 20.0, 0.0, -40.0)},
               {50.0, above_hills(200.0, 80.0, 40.0, 140.0, -80.0)}};
  write_camera_path(at("long.json"), path);
  std::filesystem::create_directory(at("stopped"));
  const ProcessResult drawn =
      run_process({kViewer, at("hills.hlod"), "--headless", "--no-progress", "--path",
                   at("long.json"), "-o", at("stopped/%05d.png"), "--size", "200x150"},
                  SIGINT, at("stopped/00001.png"));
  EXPECT_EQ(drawn.exit_code, 128 + SIGINT);
  EXPECT_EQ(test::line_count(drawn.err), 2u) << drawn.err;
  int pictures = 0;
  for (const auto& entry : std::filesystem::directory_iterator(at("stopped"))) {
    EXPECT_EQ(entry.path().extension(), ".png") << entry.path();
    EXPECT_EQ(test::read_png(entry.path()).width, 200) << entry.path();
    ++pictures;
  }
  EXPECT_GE(pictures, 2);
  EXPECT_LT(pictures, 5001);
  std::array<char, 16> last{};
  std::snprintf(last.data(), last.size(), "%05d.png", pictures - 1);
  EXPECT_TRUE(std::filesystem::exists(at("stopped") + "/" + last.data()));
  EXPECT_NE(drawn.err.find(std::to_string(pictures) + " of 5001 frames are written, the last is " +
                           at("stopped/") + last.data() + "\n"),
            std::string::npos)
      << drawn.err;
}

TEST_F(Viewer, MakesTheFolderOfItsPicturesAndLeavesNothingOnAFullDisk) {
  ASSERT_EQ(view({"-o", at("new/folder/a.png"), "--size", "64x48"}).exit_code, 0);
  EXPECT_EQ(test::read_png(at("new/folder/a.png")).width, 64);
  const test::TemporaryFolder disk;
  const auto outcome = test::on_full_disk(disk.path(), [&] {
    const ProcessResult drawn =
        view({"-o", (disk / "big.png").string(), "--size", "1600x1200", "--samples", "1"});
    const bool is_left = std::filesystem::exists(disk / "big.png");
    throw RunError("", std::to_string(drawn.exit_code) + (is_left ? " left " : " ") + drawn.err);
  });
  if (!outcome) GTEST_SKIP() << "nobody may mount a small disk here";
  EXPECT_EQ(outcome->rfind("1 cornice-viewer: error: ", 0), 0u) << *outcome;
  EXPECT_NE(outcome->find("big.png"), std::string::npos) << *outcome;
}

TEST_F(Viewer, ReportsByTheSchemaOfAllReports) {
  ASSERT_EQ(view({"-o", at("s.png"), "--size", "64x48", "--shading", "overdraw", "--report",
                  at("s.json")})
                .exit_code,
            0);
  const ProcessResult checked =
      run_process({"/usr/bin/python3", "-c",
                   "import json, sys, jsonschema\n"
                   "schema = json.load(open(sys.argv[1]))\n"
                   "jsonschema.Draft7Validator(schema).validate(json.load(open(sys.argv[2])))\n",
                   CORNICE_SOURCE_DIR "/docs/report.schema.json", at("s.json")});
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
  EXPECT_GE(test::read_json(at("s.json"))["quality"]["overdraw, median"].get<double>(), 1.0);
}

TEST_F(Viewer, KeepsToTheMemoryOfTheGpuAndSaysThatPicturesAreCoarser) {
  write_camera(at("near.json"), above_hills(130.0, 90.0, 3.0, 0.0, -20.0));
  const ProcessResult drawn =
      view({"-o", at("small.png"), "--camera", at("near.json"), "--size", "200x150",
            "--error-pixels", "0.1", "--gpu-memory-mib", "16", "--report", at("small.json")});
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  std::ifstream report(at("small.json"));
  const auto quality = nlohmann::json::parse(report)["quality"];
  EXPECT_LE(quality["memory on the GPU, MiB"].get<double>(), 16.0);
}

TEST_F(Viewer, DrawsTheParentOfADamagedCellAndNamesTheCell) {
  std::string bytes = test::read_text(at("hills.hlod"));
  // The blocks lie between the header and the node table at the end; the finest are last.
  for (std::size_t part = 6; part < 17; ++part)
    bytes[bytes.size() * part / 20] = static_cast<char>(bytes[bytes.size() * part / 20] ^ 0x55);
  test::write_text(at("damaged.hlod"), bytes);
  const ProcessResult drawn =
      view({"-o", at("damaged.png"), "--size", "200x150", "--no-sky", "--error-pixels", "0.1"},
           "damaged.hlod");
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_NE(drawn.err.find("cell "), std::string::npos) << drawn.err;
  EXPECT_NE(drawn.err.find("parent is drawn"), std::string::npos) << drawn.err;
}

TEST_F(Viewer, RefusesWhatItCannotUseInOneLine) {
  test::write_text(at("no.hlod"), "this is no hierarchy");
  const auto expect = [&](const ProcessResult& result, int code, const std::string& part) {
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_EQ(test::line_count(result.err), 1u) << result.err;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
  };
  expect(view({"-o", at("x.png")}, "no.hlod"), 3, "no.hlod");
  expect(view({"-o", at("x.png")}, "missing.hlod"), 3, "missing.hlod");
  for (const char* size : {"0x9", "-4x4", "16385x4", "4", "4x4x4"})
    expect(view({"-o", at("x.png"), std::string("--size=") + size}), 2, "--size");
  expect(view({"-o", at("x.gif")}), 2, "x.gif");
  expect(view({"-o", at("x_%s.png")}), 2, "--output");
  write_camera_path(at("p.json"), CameraPath{{{0.0, above_hills(9.0, 9.0, 9.0, 0.0, 0.0)}}, 10.0});
  expect(view({"-o", at("x.png"), "--path", at("p.json")}), 2, "%04d");
  expect(view({"-o", at("x_%d_%d.png"), "--path", at("p.json")}), 2, "--output");
  expect(view({"-o", at("x.png"), "--time", "noon"}), 2, "--time");
  test::write_text(at("bad.json"), "{\"eye\": 3}");
  expect(view({"-o", at("x.png"), "--camera", at("bad.json")}), 3, "eye");
  expect(view({"-o", at("x.png"), "--path", at("bad.json")}), 3, "keys");
  expect(view({"-o", at("x.png"), "--path", at("p.json"), "--save-camera", at("c.json")}), 2,
         "--save-camera");
}

}  // namespace
}  // namespace cornice::viewer
