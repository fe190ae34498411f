// The C# file against a ball with known answers; exit 1 where one is wrong.
// usage: mono CsharpTest.exe MODEL      MODEL: sqmap shapes sphere, baked
using System;
using Sqmap;

static class CsharpTest
{
    static int checks;

    static void Expect(bool holds, string what)
    {
        ++checks;
        if (holds) return;
        Console.Error.WriteLine("wrong: " + what);
        Environment.Exit(1);
    }

    static void Refuses(string name, Action call)
    {
        try
        {
            call();
        }
        catch (SqmapException e)
        {
            Expect(e.Name == name && e.Element.Length > 0 && e.Cure.Length > 0, name + " is " + e.Name + ": " + e.Message);
            return;
        }
        Expect(false, name + " was not thrown");
    }

    static void Main(string[] arguments)
    {
        var model = Model.Open(arguments[0]);
        double r = model.RMax / 2;
        Expect(model.Triangles > 100 && model.Info.Contains("\"parts\""), "facts");
        double[] points = { 0, 0, 0.9 * r, 0, 2 * r, 0, 0, 0, 0 };
        Contacts a = model.Query(points, Layer.Exact);
        Expect(a.Count == 2 && a.Contact[0] == 1 && a.Contact[1] == 0, "verdicts");
        Expect(Math.Abs(a.Depth[0] - 0.1 * r) < 0.02 * r && a.Normal[2] > 0.99, "depth and normal");
        Distances d = model.SignedDistances(points);
        Expect(Math.Abs(d.Distance[0] + 0.1 * r) < 0.02 * r && Math.Abs(d.Distance[1] - r) < 0.02 * r, "distances");
        Pose moved = Pose.Identity;
        moved.Translation = new[] { 10 * r, 0, 0 };
        Expect(model.Query(points, Layer.Maps, moved).Count == 0, "a moved model");

        Model box = Model.Bake(new double[] { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1 },
                               new long[] { 0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7 });
        Expect(Math.Abs(box.Query(new[] { 0.5, 0.5, 0.9 }, Layer.Exact).Depth[0] - 0.1) < 1e-6, "a baked box");

        using (ForceSession session = model.Touch(0.01 * r, 0.1 / r, 200, 3))
        {
            double pushed = 0;
            for (int tick = 0; tick < 2000; ++tick)
            {
                double z = 0.1 * (1.2 - 0.2 * Math.Min(1, tick / 1000.0));  // into the ball of 10 cm, slowly
                Force f = session.Tick(1e-3 * (tick + 1), 0, 0, z);
                Expect(Math.Abs(f.Newtons[2]) <= 3 + 1e-9, "within the limit");
                pushed = f.Newtons[2];
            }
            Expect(pushed > 0.2, "pushed out with " + pushed + " N");
        }
        using (ForceSession session = model.Touch(0, 0.1 / r, 200, 3, Mode.Proxy))
        {
            Force f = session.Tick(1e-3, 0, 0, 0.11);
            for (int tick = 1; tick < 1000; ++tick) f = session.Tick(1e-3 * (tick + 1), 0, 0, 0.11 - 2e-5 * tick);
            Expect(Math.Abs(f.Tool.Translation[2] - 0.1) < 0.002 && f.Tool.Translation[2] - 0.09 > 0.005, "a proxy on the surface");
        }

        Refuses("E_FILE", () => Model.Open("/no/such/file"));
        Refuses("E_MODEL", () => Model.Open(new byte[100]));
        Refuses("E_INDEX", () => Model.Bake(new double[] { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, new long[] { 0, 1, 9 }));
        Refuses("E_ARGUMENT", () => model.Query(new double[4]));
        Refuses("E_ARGUMENT", () => model.Query(points, (Layer)17));
        model.Dispose();
        Refuses("E_HANDLE", () => model.Query(points));
        Console.WriteLine("C#: " + checks + " checks of sqmap " + Model.Version);
    }
}
