// sqmap for .NET and Unity: sqmap.h by P/Invoke, in one file. Put it into a project, and libsqmap.so.0 (Linux) or libsqmap.dll
// (Windows) where the system finds libraries; in Unity, into Assets/Plugins. Points are x, y, z one behind the other, in the mesh's
// own frame and units. Any number of threads may query a Model; a ForceSession belongs to one thread at a time.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Sqmap
{
    /// <summary>Why a call failed. Name: "E_ARGUMENT", "E_MODEL", "E_HANDLE"; of a mesh the gate's own: "E_OPEN".</summary>
    public sealed class SqmapException : Exception
    {
        public readonly string Name, Element, Cure;
        public SqmapException(string name, string element, string message, string cure) : base(element + ": " + message + "; " + cure)
        {
            Name = name;
            Element = element;
            Cure = cure;
        }
    }

    /// <summary>How the tool follows the device: it is there, it stays on the surface and is pulled, or it is a body on
    /// springs.</summary>
    public enum Mode { Default = 0, Direct = 1, Proxy = 2, Coupled = 3 }

    public enum Layer { Default = 0, Superquadrics = 1, Planes = 2, Maps = 3, Exact = 4, Auto = 5 }

    /// <summary>x in the caller's frame = Rotation x + Translation; the rotation row by row.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Pose
    {
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 9)] public double[] Rotation;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] Translation;
        public static Pose Identity
        {
            get { return new Pose { Rotation = new double[] { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, Translation = new double[3] }; }
        }
    }

    /// <summary>Answers of n points; rows of three numbers for Normal and Closest.</summary>
    public sealed class Contacts
    {
        public byte[] Contact, Certain, Status;
        public double[] Depth, Normal, Closest;
        public int[] Part;
        public int Count;
    }

    /// <summary>Signed distances of n points, negative inside.</summary>
    public sealed class Distances
    {
        public double[] Distance, Gradient, Closest;
        public int[] Part;
        public byte[] Known, Status;
    }

    /// <summary>What a tick of a session gives; newtons and metres. All zero where anything is faulty.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Force
    {
        internal UIntPtr Size;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] Newtons;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] Torque;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] Commanded;
        public double Depth;
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] public double[] Normal;
        public uint Status, Acted, Faults;
        public int IsEngaged;
        /// <summary>Where the tool is: the device's pose, the proxy's or the coupled body's.</summary>
        public Pose Tool;
    }

    static class Native
    {
        const string Library = "libsqmap";

        [StructLayout(LayoutKind.Sequential)]
        internal struct Handle
        {
            internal ulong Id;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Error
        {
            internal UIntPtr Size;
            internal int Code;
            internal IntPtr Name, Element, Message, Cure;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Text
        {
            internal UIntPtr Size;
            internal IntPtr Value;
            internal UIntPtr Capacity, Needed;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Mesh
        {
            internal UIntPtr Size;
            internal IntPtr Vertices;
            internal UIntPtr VertexCount;
            internal IntPtr Triangles;
            internal UIntPtr TriangleCount;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Facts
        {
            internal UIntPtr Size;
            internal double RMax, Band;
            [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] internal double[] Centre;
            internal double Radius;
            internal ulong Bytes;
            internal uint Parts, Vertices, Triangles;
            internal int IsSolid, HasExact, IsNormal, IsDoubtful;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct QueryOptions
        {
            internal UIntPtr Size;
            internal int Layer;
            internal uint Threads;
            internal double Tolerance, Margin, Band;
            internal int IsSmooth, IsFirstOnly;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Points
        {
            internal UIntPtr Size;
            internal IntPtr Xyz;
            internal UIntPtr Count;
            internal IntPtr Pose;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct ContactArrays
        {
            internal UIntPtr Size;
            internal IntPtr Contact, Depth, Normal, Closest, Part, Certain, Status;
            internal UIntPtr Contacts;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct DistanceArrays
        {
            internal UIntPtr Size;
            internal IntPtr Distance, Gradient, Closest, Part, Known, Status;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct SessionOptions
        {
            internal UIntPtr Size;
            internal double MetresPerUnit;
            internal IntPtr Pose;
            internal double Radius, Stiffness, Damping, Friction;
            internal int Layer;
            internal double MaxForce, MaxTorque, ContinuousForce, ForceLimit, TorqueLimit;
            internal int HasDeadMan;
            internal double SidePath;
            internal int Mode;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Tick
        {
            internal UIntPtr Size;
            internal double Time, SampleTime;
            internal ulong Sequence;
            internal Pose Pose;
            internal uint Acts;
        }

        [DllImport(Library)] internal static extern IntPtr sqmap_last_error();
        [DllImport(Library)] internal static extern IntPtr sqmap_version();
        [DllImport(Library)] internal static extern int sqmap_open(byte[] path, out Handle model);
        [DllImport(Library)] internal static extern int sqmap_open_bytes(byte[] bytes, UIntPtr size, out Handle model);
        [DllImport(Library)] internal static extern int sqmap_bake(ref Mesh mesh, IntPtr options, out Handle model);
        [DllImport(Library)] internal static extern int sqmap_save(Handle model, byte[] path);
        [DllImport(Library)] internal static extern int sqmap_model_facts(Handle model, ref Facts facts);
        [DllImport(Library)] internal static extern int sqmap_info(Handle model, ref Text json);
        [DllImport(Library)] internal static extern int sqmap_close_model(Handle model);
        [DllImport(Library)] internal static extern int sqmap_query_points(Handle model, ref Points points, ref QueryOptions options,
                                                                           ref ContactArrays contacts);
        [DllImport(Library)] internal static extern int sqmap_exact_distances(Handle model, ref Points points,
                                                                              ref QueryOptions options, ref DistanceArrays distances);
        [DllImport(Library)] internal static extern int sqmap_signed_distances(Handle model, ref Points points,
                                                                               ref QueryOptions options, ref DistanceArrays distances);
        [DllImport(Library)] internal static extern int sqmap_make_session(Handle model, ref SessionOptions options, out Handle session);
        [DllImport(Library)] internal static extern int sqmap_tick_session(Handle session, ref Tick tick, ref Force force);
        [DllImport(Library)] internal static extern int sqmap_close_session(Handle session);

        internal static UIntPtr SizeOf<T>() { return (UIntPtr)Marshal.SizeOf(typeof(T)); }

        internal static string Utf8(IntPtr text)
        {
            int length = 0;
            while (Marshal.ReadByte(text, length) != 0) ++length;
            byte[] bytes = new byte[length];
            Marshal.Copy(text, bytes, 0, length);
            return Encoding.UTF8.GetString(bytes);
        }

        internal static byte[] Utf8(string text) { return Encoding.UTF8.GetBytes(text + "\0"); }

        internal static void Check(int code)
        {
            if (code == 0) return;
            var e = (Error)Marshal.PtrToStructure(sqmap_last_error(), typeof(Error));
            throw new SqmapException(Utf8(e.Name), Utf8(e.Element), Utf8(e.Message), Utf8(e.Cure));
        }
    }

    /// <summary>Arrays that the library reads and writes while this exists.</summary>
    sealed class Pins : IDisposable
    {
        readonly System.Collections.Generic.List<GCHandle> handles = new System.Collections.Generic.List<GCHandle>();
        IntPtr pose = IntPtr.Zero;

        internal IntPtr Of(Array array)
        {
            if (array == null) throw new ArgumentNullException("array");
            var handle = GCHandle.Alloc(array, GCHandleType.Pinned);
            handles.Add(handle);
            return handle.AddrOfPinnedObject();
        }
        internal IntPtr Of(Pose? value)
        {
            if (value == null) return IntPtr.Zero;
            pose = Marshal.AllocHGlobal(Marshal.SizeOf(typeof(Pose)));
            Marshal.StructureToPtr(value.Value, pose, false);
            return pose;
        }
        internal Native.Points Points(double[] xyz, Pose? at)
        {
            if (xyz.Length % 3 != 0) throw new SqmapException("E_ARGUMENT", "points", "has " + xyz.Length + " numbers", "give three a point");
            return new Native.Points { Size = Native.SizeOf<Native.Points>(), Xyz = Of(xyz), Count = (UIntPtr)(xyz.Length / 3), Pose = Of(at) };
        }
        public void Dispose()
        {
            foreach (GCHandle handle in handles) handle.Free();
            if (pose != IntPtr.Zero) Marshal.FreeHGlobal(pose);
        }
    }

    /// <summary>A baked model.</summary>
    public sealed class Model : IDisposable
    {
        Native.Handle handle;

        Model(Native.Handle handle) { this.handle = handle; }

        /// <summary>"0.2.0"</summary>
        public static string Version { get { return Native.Utf8(Native.sqmap_version()); } }

        public static Model Open(string path)
        {
            Native.Handle handle;
            Native.Check(Native.sqmap_open(Native.Utf8(path), out handle));
            return new Model(handle);
        }
        public static Model Open(byte[] bytes)
        {
            Native.Handle handle;
            Native.Check(Native.sqmap_open_bytes(bytes, (UIntPtr)bytes.Length, out handle));
            return new Model(handle);
        }
        /// <summary>Bakes triangles, zero-based; seconds for some thousand.</summary>
        public static Model Bake(double[] vertices, long[] triangles)
        {
            using (var pins = new Pins())
            {
                var mesh = new Native.Mesh {
                    Size = Native.SizeOf<Native.Mesh>(), Vertices = pins.Of(vertices), VertexCount = (UIntPtr)(vertices.Length / 3),
                    Triangles = pins.Of(triangles), TriangleCount = (UIntPtr)(triangles.Length / 3)
                };
                Native.Handle handle;
                Native.Check(Native.sqmap_bake(ref mesh, IntPtr.Zero, out handle));
                return new Model(handle);
            }
        }
        public void Save(string path) { Native.Check(Native.sqmap_save(handle, Native.Utf8(path))); }

        Native.Facts Facts
        {
            get
            {
                var facts = new Native.Facts { Size = Native.SizeOf<Native.Facts>(), Centre = new double[3] };
                Native.Check(Native.sqmap_model_facts(handle, ref facts));
                return facts;
            }
        }
        /// <summary>Largest distance between two vertices.</summary>
        public double RMax { get { return Facts.RMax; } }
        public double[] Centre { get { return Facts.Centre; } }
        public double Radius { get { return Facts.Radius; } }
        public uint Parts { get { return Facts.Parts; } }
        public uint Triangles { get { return Facts.Triangles; } }

        /// <summary>All that sqmap info --json prints.</summary>
        public string Info
        {
            get
            {
                var text = new Native.Text { Size = Native.SizeOf<Native.Text>() };
                Native.Check(Native.sqmap_info(handle, ref text));
                text.Capacity = text.Needed;
                text.Value = Marshal.AllocHGlobal((int)text.Needed);
                try
                {
                    Native.Check(Native.sqmap_info(handle, ref text));
                    return Native.Utf8(text.Value);
                }
                finally
                {
                    Marshal.FreeHGlobal(text.Value);
                }
            }
        }

        /// <summary>Which points are inside, how deep, and in which direction out. pose: of the model in the points' frame.</summary>
        public Contacts Query(double[] points, Layer layer = Layer.Default, Pose? pose = null)
        {
            int n = points.Length / 3;
            var a = new Contacts {
                Contact = new byte[n], Certain = new byte[n], Status = new byte[n], Depth = new double[n], Normal = new double[3 * n],
                Closest = new double[3 * n], Part = new int[n]
            };
            using (var pins = new Pins())
            {
                var at = pins.Points(points, pose);
                var options = new Native.QueryOptions { Size = Native.SizeOf<Native.QueryOptions>(), Layer = (int)layer };
                var to = new Native.ContactArrays {
                    Size = Native.SizeOf<Native.ContactArrays>(), Contact = pins.Of(a.Contact), Depth = pins.Of(a.Depth),
                    Normal = pins.Of(a.Normal), Closest = pins.Of(a.Closest), Part = pins.Of(a.Part), Certain = pins.Of(a.Certain),
                    Status = pins.Of(a.Status)
                };
                Native.Check(Native.sqmap_query_points(handle, ref at, ref options, ref to));
                a.Count = (int)to.Contacts;
            }
            return a;
        }

        /// <summary>Signed distances on both sides: exact, in double. With a finite band in float, exact within band of the surface
        /// and a bound beyond it; 0: as baked, for real time.</summary>
        public Distances SignedDistances(double[] points, double band = double.PositiveInfinity, Pose? pose = null)
        {
            int n = points.Length / 3;
            var a = new Distances {
                Distance = new double[n], Gradient = new double[3 * n], Closest = new double[3 * n], Part = new int[n],
                Known = new byte[n], Status = new byte[n]
            };
            using (var pins = new Pins())
            {
                var at = pins.Points(points, pose);
                var options = new Native.QueryOptions { Size = Native.SizeOf<Native.QueryOptions>(), Band = band };
                var to = new Native.DistanceArrays {
                    Size = Native.SizeOf<Native.DistanceArrays>(), Distance = pins.Of(a.Distance), Gradient = pins.Of(a.Gradient),
                    Closest = pins.Of(a.Closest), Part = pins.Of(a.Part), Known = pins.Of(a.Known), Status = pins.Of(a.Status)
                };
                Native.Check(double.IsPositiveInfinity(band)
                    ? Native.sqmap_exact_distances(handle, ref at, ref options, ref to)
                    : Native.sqmap_signed_distances(handle, ref at, ref options, ref to));
            }
            return a;
        }

        /// <summary>Forces of a ball of this radius (metres; 0: a point) that touches the model.</summary>
        public ForceSession Touch(double radius, double metresPerUnit = 1, double stiffness = 500, double maxForce = 0,
                                  Mode mode = Mode.Default)
        {
            var options = new Native.SessionOptions {
                Size = Native.SizeOf<Native.SessionOptions>(), MetresPerUnit = metresPerUnit, Radius = radius, Stiffness = stiffness,
                MaxForce = maxForce, Mode = (int)mode
            };
            Native.Handle session;
            Native.Check(Native.sqmap_make_session(handle, ref options, out session));
            return new ForceSession(session);
        }

        /// <summary>Whatever is called afterwards throws.</summary>
        public void Dispose()
        {
            if (handle.Id != 0) Native.sqmap_close_model(handle);
            handle.Id = ulong.MaxValue;  // no handle is that: later calls say so
            GC.SuppressFinalize(this);
        }
        ~Model() { if (handle.Id != 0 && handle.Id != ulong.MaxValue) Native.sqmap_close_model(handle); }
    }

    /// <summary>A tool that touches a model, behind the safety filter: one step for each event of the device. Research software,
    /// not a safety device.</summary>
    public sealed class ForceSession : IDisposable
    {
        Native.Handle handle;
        ulong ticks;

        internal ForceSession(Native.Handle handle) { this.handle = handle; }

        /// <summary>One fresh reading of the device: time in seconds, monotonic; the tool's position in metres.</summary>
        public Force Tick(double time, double x, double y, double z)
        {
            var pose = Pose.Identity;
            pose.Translation = new[] { x, y, z };
            var tick = new Native.Tick { Size = Native.SizeOf<Native.Tick>(), Time = time, SampleTime = time, Sequence = ++ticks, Pose = pose };
            var force = new Force {
                Size = Native.SizeOf<Force>(), Newtons = new double[3], Torque = new double[3], Commanded = new double[3],
                Normal = new double[3], Tool = Pose.Identity
            };
            Native.Check(Native.sqmap_tick_session(handle, ref tick, ref force));
            return force;
        }
        public void Dispose()
        {
            if (handle.Id != 0) Native.sqmap_close_session(handle);
            handle.Id = ulong.MaxValue;
            GC.SuppressFinalize(this);
        }
        ~ForceSession() { if (handle.Id != 0 && handle.Id != ulong.MaxValue) Native.sqmap_close_session(handle); }
    }
}
