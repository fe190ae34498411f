// Model files on disk: written whole, replaced whole, mapped or refused.
#include "queried_model.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace sqmap::io {
namespace {

namespace fs = std::filesystem;

/// A folder of its own, removed with all in it.
class ModelFolder : public testing::Test {
protected:
    void SetUp() override
    {
        std::string pattern = (fs::temp_directory_path() / "sqmap-model-XXXXXX").string();
        ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
    }
    void TearDown() override
    {
        fs::permissions(folder_, fs::perms::owner_all);
        fs::remove_all(folder_);
    }
    [[nodiscard]] std::size_t files() const
    {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}));
    }
    static std::vector<std::byte> read(const fs::path& path)
    {
        std::ifstream in(path, std::ios::binary);
        const std::string text((std::istreambuf_iterator<char>(in)), {});
        const auto* begin = reinterpret_cast<const std::byte*>(text.data());
        return {begin, begin + text.size()};
    }
    static void write(const fs::path& path, std::span<const std::byte> bytes)
    {
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }
    fs::path folder_;
};

TEST_F(ModelFolder, AWrittenModelIsMappedBackWholeAndAlone)
{
    const fs::path path = folder_ / "a.sqmap";
    write_model(torus_model(), path);
    EXPECT_EQ(files(), 1u);
    EXPECT_EQ(read(path), serialize(torus_model()));
    MappedModel first(path);
    EXPECT_EQ(first.view().made_by, "test");
    EXPECT_EQ(first.view().source, "torus.obj");
    EXPECT_EQ(first.view().options, "none");
    EXPECT_NE(first.view().mesh_hash, 0u);
    EXPECT_EQ(first.view().mesh_hash, torus_model().mesh_hash);
    EXPECT_EQ(first.view().measured.points, torus_model().measured.points);
    EXPECT_EQ(first.view().measured.depth_p99, torus_model().measured.depth_p99);
    EXPECT_EQ(first.view().measured.eq35_mean, torus_model().measured.eq35_mean);
    EXPECT_EQ(model::content_hash(first.view()), model::content_hash(torus_model().view()));
    const MappedModel moved(std::move(first));
    interrogate(moved.view(), 2);
    EXPECT_EQ(moved.size(), fs::file_size(path));
    EXPECT_EQ(moved.bytes().size(), moved.size());
}

TEST_F(ModelFolder, AModelFromBeforeTheMeshHashIsRead)
{
    // A default is not stored: these are the bytes of a writer that does not know the field.
    model::ModelData old = torus_model();
    old.mesh_hash = 0;
    const fs::path path = folder_ / "old.sqmap";
    write_model(old, path);
    const MappedModel mapped(path);
    EXPECT_EQ(mapped.view().mesh_hash, 0u);
    interrogate(mapped.view(), 3);
}

TEST_F(ModelFolder, WritingReplacesAnOldFileWhole)
{
    const fs::path path = folder_ / "a.sqmap";
    write(path, std::vector<std::byte>(3'000'000, std::byte{7}));
    write_model(torus_model(), path);
    EXPECT_EQ(read(path), serialize(torus_model()));
    EXPECT_EQ(files(), 1u);
}

TEST_F(ModelFolder, AFailedWriteLeavesTheOldFileAndNothingElse)
{
    // The rename fails where the target is a folder that is not empty: after everything was written.
    const fs::path path = folder_ / "a.sqmap";
    fs::create_directory(path);
    write(path / "kept", std::vector<std::byte>(10, std::byte{1}));
    EXPECT_THROW(write_model(torus_model(), path), ModelFileError);
    EXPECT_EQ(files(), 1u);
    EXPECT_EQ(read(path / "kept").size(), 10u);
}

TEST_F(ModelFolder, AFolderThatIsNotThereIsSaidSo)
{
    EXPECT_THROW(write_model(torus_model(), folder_ / "no" / "such" / "a.sqmap"), ModelFileError);
    EXPECT_EQ(files(), 0u);
}

TEST_F(ModelFolder, AnUnwritableFolderKeepsItsOldFile)
{
    const fs::path path = folder_ / "a.sqmap";
    write(path, std::vector<std::byte>(5, std::byte{1}));
    fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read | fs::perms::others_exec);
    // Root may write everywhere, and so becomes somebody else while the model is written.
    const bool root = ::geteuid() == 0;
    if (root && ::seteuid(65534) != 0) GTEST_SKIP() << "root may write everywhere: run the tests as another user";
    EXPECT_THROW(write_model(torus_model(), path), ModelFileError);
    if (root) {
        ASSERT_EQ(::seteuid(0), 0);
    }
    EXPECT_EQ(read(path).size(), 5u);
    EXPECT_EQ(files(), 1u);
}

TEST_F(ModelFolder, AFullDiskLeavesNothingBehind)
{
    // A limit on the size of files stands in for a full disk: write() fails in the middle.
    const fs::path path = folder_ / "a.sqmap";
    const auto write_under_limit = [&] {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit limit = {4096, 4096};
        ::setrlimit(RLIMIT_FSIZE, &limit);
        try {
            write_model(torus_model(), path);
        } catch (const ModelFileError&) {
            std::_Exit(3);
        }
        std::_Exit(0);
    };
    EXPECT_EXIT(write_under_limit(), testing::ExitedWithCode(3), "");
    EXPECT_EQ(files(), 0u);
}

TEST_F(ModelFolder, WhatIsNoModelIsNotMapped)
{
    EXPECT_THROW(MappedModel(folder_ / "absent.sqmap"), ModelFileError);
    EXPECT_THROW(MappedModel{folder_}, ModelFileError);
    write(folder_ / "empty.sqmap", {});
    EXPECT_THROW(MappedModel(folder_ / "empty.sqmap"), ModelFileError);
    write(folder_ / "short.sqmap", std::vector<std::byte>(5, std::byte{'S'}));
    EXPECT_THROW(MappedModel(folder_ / "short.sqmap"), ModelFileError);
    const std::string text = "OFF\n8 12 0\n0 0 0\n1 0 0\n";
    write(folder_ / "mesh.off", std::as_bytes(std::span(text)));
    EXPECT_THROW(MappedModel(folder_ / "mesh.off"), ModelFileError);
    std::vector<std::byte> bytes = serialize(torus_model());
    bytes.resize(bytes.size() / 2);
    write(folder_ / "half.sqmap", bytes);
    try {
        const MappedModel half(folder_ / "half.sqmap");
        ADD_FAILURE() << "half a model was mapped";
    } catch (const ModelFileError& e) {
        EXPECT_NE(std::string(e.what()).find("half.sqmap"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace sqmap::io
