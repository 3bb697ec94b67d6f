// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-hlod info, verify and extract on what cornice-hlod build writes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/ply.h"
#include "tests/support/meshes.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::ProcessResult;
using test::TemporaryFolder;
using testing::HasSubstr;

constexpr const char* kTool = CORNICE_BIN_DIR "/cornice-hlod";

ProcessResult run(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), kTool);
  arguments.emplace_back("--no-progress");
  return test::run_process(arguments);
}

class HlodFileCommands : public testing::Test {
 protected:
  void SetUp() override {
    Mesh mesh = test::height_mesh(0, 0, 120, 1.0, [](double x, double y) {
      return 20.0 + 6.0 * std::sin(0.1 * x) * std::cos(0.07 * y);
    });
    mesh.origin = {2'600'000.0, 1'200'000.0, 0.0};
    mesh.crs_text = "EPSG:2056";
    write_ply(folder_ / "in.ply", mesh);
    const ProcessResult built =
        run({"build", folder_ / "in.ply", "-o", file_, "--cell-side", "16"});
    ASSERT_EQ(built.exit_code, 0) << built.err;
  }

  TemporaryFolder folder_;
  std::string file_ = folder_ / "a.hlod";
};

TEST_F(HlodFileCommands, InfoSaysWhatIsInAFile) {
  const ProcessResult text = run({"info", file_});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("EPSG:2056"));
  const ProcessResult machine = run({"info", file_, "--json"});
  const auto json = nlohmann::json::parse(machine.out);
  EXPECT_EQ(json["partition"], "quadtree");
  EXPECT_EQ(json["triangles_finest"], 2 * 120 * 120);
  EXPECT_EQ(json["level"].size(), json["levels"].get<std::size_t>());
  EXPECT_EQ(json["level"].back()["cell_side_m"], 16.0);
  EXPECT_EQ(json["level"].back()["error_max_m"], 0.0);
  EXPECT_EQ(json["provenance"]["inputs"][0], "in.ply");
}

TEST_F(HlodFileCommands, VerifyAcceptsASoundFileAndRefusesADamagedOne) {
  const ProcessResult sound = run({"verify", file_});
  EXPECT_EQ(sound.exit_code, 0) << sound.err;
  std::string bytes = test::read_text(file_);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  test::write_text(folder_ / "bad.hlod", bytes);
  const ProcessResult bad = run({"verify", folder_ / "bad.hlod"});
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_THAT(bad.err, HasSubstr("checksum"));
  test::write_text(folder_ / "cut.hlod", bytes.substr(0, bytes.size() - 100));
  EXPECT_EQ(run({"info", folder_ / "cut.hlod"}).exit_code, 3);
}

TEST_F(HlodFileCommands, ExtractGivesLevelsAndViews) {
  const std::string finest = folder_ / "finest.ply";
  ASSERT_EQ(run({"extract", file_, "-o", finest, "--error-m", "0"}).exit_code, 0);
  const Mesh mesh = read_ply_mesh(finest);
  EXPECT_EQ(mesh.triangles.size(), 2u * 120 * 120);
  EXPECT_EQ(mesh.positions.size(), 121u * 121);
  EXPECT_EQ(mesh.crs_text, "EPSG:2056");
  const std::string coarse = folder_ / "coarse.glb";
  ASSERT_EQ(run({"extract", file_, "-o", coarse, "--level", "0"}).exit_code, 0);
  EXPECT_GT(std::filesystem::file_size(coarse), 500u);
  const std::string view = folder_ / "view.ply";
  ASSERT_EQ(run({"extract", file_, "-o", view, "--eye", "2600010,1200010,30"}).exit_code, 0);
  EXPECT_GT(read_ply_mesh(view).triangles.size(), 100u);
}

TEST_F(HlodFileCommands, ExtractRefusesWhatMakesNoSense) {
  const std::string out = folder_ / "x.ply";
  EXPECT_EQ(run({"extract", file_, "-o", out}).exit_code, 2);
  EXPECT_EQ(run({"extract", file_, "-o", out, "--level", "1", "--error-m", "1"}).exit_code, 2);
  EXPECT_EQ(run({"extract", file_, "-o", out, "--level", "16"}).exit_code, 2);
  EXPECT_EQ(run({"extract", file_, "-o", out, "--level", "0.5"}).exit_code, 2);
  EXPECT_EQ(run({"extract", file_, "-o", out, "--eye", "1,2"}).exit_code, 2);
  EXPECT_EQ(run({"extract", file_, "-o", folder_ / "x.txt", "--level", "0"}).exit_code, 2);
  EXPECT_EQ(run({"extract", folder_ / "in.ply", "-o", out, "--level", "0"}).exit_code, 3);
}

}  // namespace
}  // namespace cornice
