/* -- opening and closing ---------------------------------------------------------------------------

   A file is mapped where the system can do that, and read into memory otherwise. */

#ifdef RBTI_MMAP

RBT_API int rbt_open(const char *path, rbt_table **table)
{
    RBTI_REQUIRE(table, RBT_ERR_MISSING);
    *table = NULL;
    RBTI_REQUIRE(path, RBT_ERR_MISSING);
    const int file = open(path, O_RDONLY | O_NONBLOCK); /* opening a pipe would wait for its writer */
    if (file < 0)
        return RBT_ERR_NOT_OPENED;
    struct stat about;
    if (fstat(file, &about) != 0 || !S_ISREG(about.st_mode)) {
        close(file);
        return RBT_ERR_NOT_READ;
    }
    /* compared as 64 bits, since off_t has 32 bits on some machines */
    if (about.st_size <= 0 || (uint64_t)about.st_size >= RBTI_MOST_BYTES) {
        close(file);
        return about.st_size <= 0 ? RBT_ERR_FORMAT : RBT_ERR_SIZE;
    }
    const size_t size = (size_t)about.st_size;
    void *image = mmap(NULL, size, PROT_READ, MAP_PRIVATE, file, 0);
    close(file);
    if (image == MAP_FAILED)
        return RBT_ERR_NOT_READ;
    const int code = rbt_open_memory(image, size, table);
    if (code == RBT_OK)
        (*table)->to_unmap = image;
    else
        munmap(image, size);
    return code;
}

#else

/* Read a whole file to an address that is a multiple of 64. */
static int rbti_read_file(FILE *file, void **memory, char **image, size_t *size)
{
    if (fseek(file, 0, SEEK_END) != 0)
        return RBT_ERR_NOT_READ;
    const long end = ftell(file);
    if (end < 0 || fseek(file, 0, SEEK_SET) != 0)
        return RBT_ERR_NOT_READ;
    if ((unsigned long)end >= RBTI_MOST_BYTES)
        return RBT_ERR_SIZE;
    *size = (size_t)end;
    *memory = RBT_MALLOC(*size + 64);
    if (!*memory)
        return RBT_ERR_NO_MEMORY;
    *image = (char *)*memory + (64 - (uintptr_t)*memory % 64) % 64;
    return fread(*image, 1, *size, file) == *size ? RBT_OK : RBT_ERR_NOT_READ;
}

RBT_API int rbt_open(const char *path, rbt_table **table)
{
    RBTI_REQUIRE(table, RBT_ERR_MISSING);
    *table = NULL;
    RBTI_REQUIRE(path, RBT_ERR_MISSING);
#ifdef RBTI_POSIX
    struct stat about; /* opening a pipe would wait for its writer */
    if (stat(path, &about) == 0 && !S_ISREG(about.st_mode))
        return RBT_ERR_NOT_READ;
#endif
    FILE *file = fopen(path, "rb");
    if (!file)
        return RBT_ERR_NOT_OPENED;
    void *memory = NULL;
    char *image = NULL;
    size_t size = 0;
    int code = rbti_read_file(file, &memory, &image, &size);
    fclose(file);
    if (code == RBT_OK)
        code = rbt_open_memory(image, size, table);
    if (code == RBT_OK)
        (*table)->to_free = memory;
    else
        RBT_FREE(memory);
    return code;
}

#endif

RBT_API void rbt_close(rbt_table *table)
{
    if (!table)
        return;
#ifdef RBTI_MMAP
    if (table->to_unmap)
        munmap(table->to_unmap, table->image_size);
#endif
    RBT_FREE(table->to_free);
    RBT_FREE(table);
}

RBT_API const char *rbt_strerror(int code)
{
    static const struct {
        int code;
        const char *text;
    } texts[] = {
/* begin texts */
        {RBT_OK, "fine"},
        {RBT_ANGLE, "impact angle outside the table: the nearest was drawn"},
        {RBT_SPEED, "impact speed outside the table: the nearest was drawn"},
        {RBT_SPIN, "spin beyond the table, or inertia beyond the grain: the "
         "nearest was drawn"},
        {RBT_EXTRAPOLATED, "a speed at which the material pair was not measured"},
        {RBT_ERR_MISSING, "a required array or the table is missing (NULL, or a handle of"
         " 0)"},
        {RBT_ERR_NOT_FINITE, "arguments: allowed: finite numbers, speeds below 1e150 m/s, "
         "inertia 0 or more"},
        {RBT_ERR_NOT_APPROACHING, "alpha1: allowed: above 0, at most pi/2 rad; velocity: allowed:"
         " towards the wall, (velocity - wall_velocity) . normal < 0"},
        {RBT_ERR_SPEED_NOT_POSITIVE,
         "speed: allowed: above 0 m/s; velocity: allowed: 1e-150 m/s or "
         "more relative to the wall"},
        {RBT_ERR_NORMAL_NOT_USABLE, "normal: allowed: any length but zero"},
        {RBT_ERR_HALF_SIZE, "half_size: allowed: 1e-09 to 100 m"},
        {RBT_ERR_ROUGHNESS_NOT_USABLE,
         "roughness: allowed: 0 to 0.5 rad; of a profile: ra 0 or more, "
         "rq not below ra, rsm and diameter above 0, and a tilt within "
         "that"},
        {RBT_ERR_CASCADE_NOT_ENDED, "roughness: bounces without end"},
        {RBT_ERR_NO_SPIN_LAW, "spin, grain, rebound: the table has no spin law, allowed: "
         "fresh grains without spin"},
        {RBT_ERR_GRAIN_NOT_KNOWN, "grain: allowed: a shape of the spin law, and b/a and c/b from "
         "0.001 to 1"},
        {RBT_ERR_NO_WORKS, "works: the table has no works"},
        {RBT_ERR_NOT_OPENED, "file: cannot be opened, allowed: a regular file that exists "
         "and may be read"},
        {RBT_ERR_NOT_READ, "file: cannot be read, or is a folder, pipe or device"},
        {RBT_ERR_NO_MEMORY, "memory: not enough for this table"},
        {RBT_ERR_BIG_ENDIAN, "machine: is big-endian, allowed: little-endian"},
        {RBT_ERR_FORMAT, "format: is no binary rebound table (.rbt)"},
        {RBT_ERR_VERSION, "format_version: allowed: 3.x; make the file again: sampler "
         "export"},
        {RBT_ERR_SIZE, "file_bytes: the file is truncated, or longer than it says"},
        {RBT_ERR_CHECKSUM, "sha256: the contents do not have this checksum"},
        {RBT_ERR_DIMENSIONS, "dimensions: one is 0 or too large, or does not fit the others"},
        {RBT_ERR_NAMES, "names: a channel or column is unknown or occurs twice"},
        {RBT_ERR_OFFSETS, "offsets: an array does not lie in the file on a multiple of 64"},
        {RBT_ERR_INDICES, "indices: a component, class, root or child lies beyond its "
         "array"},
        {RBT_ANGLE | RBT_SPEED, "impact angle outside the table: the nearest was drawn; impact "
         "speed outside the table: the nearest was drawn"},
        {RBT_ANGLE | RBT_SPIN, "impact angle outside the table: the nearest was drawn; spin "
         "beyond the table, or inertia beyond the grain: the nearest was"
         " drawn"},
        {RBT_ANGLE | RBT_EXTRAPOLATED,
         "impact angle outside the table: the nearest was drawn; a speed"
         " at which the material pair was not measured"},
        {RBT_SPEED | RBT_SPIN, "impact speed outside the table: the nearest was drawn; spin "
         "beyond the table, or inertia beyond the grain: the nearest was"
         " drawn"},
        {RBT_SPEED | RBT_EXTRAPOLATED,
         "impact speed outside the table: the nearest was drawn; a speed"
         " at which the material pair was not measured"},
        {RBT_SPIN | RBT_EXTRAPOLATED, "spin beyond the table, or inertia beyond the grain: the "
         "nearest was drawn; a speed at which the material pair was not "
         "measured"},
        {RBT_ANGLE | RBT_SPEED | RBT_SPIN,
         "impact angle outside the table: the nearest was drawn; impact "
         "speed outside the table: the nearest was drawn; spin beyond "
         "the table, or inertia beyond the grain: the nearest was drawn"},
        {RBT_ANGLE | RBT_SPEED | RBT_EXTRAPOLATED,
         "impact angle outside the table: the nearest was drawn; impact "
         "speed outside the table: the nearest was drawn; a speed at "
         "which the material pair was not measured"},
        {RBT_ANGLE | RBT_SPIN | RBT_EXTRAPOLATED,
         "impact angle outside the table: the nearest was drawn; spin "
         "beyond the table, or inertia beyond the grain: the nearest was"
         " drawn; a speed at which the material pair was not measured"},
        {RBT_SPEED | RBT_SPIN | RBT_EXTRAPOLATED,
         "impact speed outside the table: the nearest was drawn; spin "
         "beyond the table, or inertia beyond the grain: the nearest was"
         " drawn; a speed at which the material pair was not measured"},
        {RBT_ANGLE | RBT_SPEED | RBT_SPIN | RBT_EXTRAPOLATED,
         "impact angle outside the table: the nearest was drawn; impact "
         "speed outside the table: the nearest was drawn; spin beyond "
         "the table, or inertia beyond the grain: the nearest was drawn;"
         " a speed at which the material pair was not measured"},
/* end texts */
    };
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++)
        if (texts[k].code == code)
            return texts[k].text;
    return "unknown code";
}

#endif
