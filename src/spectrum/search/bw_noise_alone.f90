module bw_noise_alone
  !! The cost of a record without lines, as noise of any colour, which describes the motion of a driven beam.
  use bw_cost, only: akaike
  use bw_kinds, only: dp
  use bw_lapack, only: dgemm, dsyev
  use bw_samples, only: samples_type, validity
  use bw_vector_noise, only: vector_noise_cost
  implicit none (type, external)
  private
  public :: cost_of_shared_motion, dies, most_orders

  integer, parameter, public :: most_colour = 1024  !! highest order of noise alone, as which a driven beam moves
  integer, parameter :: least_colour = 8          !! order in a large record
  integer, parameter, public :: most_numbers = 2**24  !! of principal components in use: twice 134 MB

contains

  pure logical function dies(samples, blows)
    !! Whether the motion dies, as no stationary noise does: the first halves of the stretches between blows have many times the
    !! energy of the second ones. Sensors count alike.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: blows(:)
    real(dp), parameter :: falls = 10            ! chosen: 150 drawn records of ambient excitation have 5 at most
    integer :: bounds(0:size(blows) + 1)
    real(dp) :: energy(2), half(2)
    logical :: valid(samples%count)
    integer :: s, b, middle
    bounds = [1, blows, samples%count + 1]
    energy = 0
    do s = 1, size(samples%value, 2)
      half = 0
      valid = validity(samples, s)
      do b = 0, size(blows)
        middle = (bounds(b) + bounds(b + 1))/2
        half = half + [energy_in(bounds(b), middle - 1), energy_in(middle, bounds(b + 1) - 1)]
      end do
      energy = energy + half/max(sum(half), tiny(1.0_dp))
    end do
    dies = energy(1) > falls*energy(2)

  contains

    pure real(dp) function energy_in(first, last) result(squares)
      !! About the mean of valid samples.
      integer, intent(in) :: first, last
      associate (x => samples%value(first:last, s), own => valid(first:last))
        squares = sum((x - sum(x, own)/max(1, count(own)))**2, own)
      end associate
    end function energy_in

  end function dies

  real(dp) function cost_of_shared_motion(samples) result(cost)
    !! J of noise alone as one motion of all sensors, or of as many of their principal components as the memory limit allows; huge
    !! if samples are missing or there are no components.
    type(samples_type), intent(in) :: samples
    real(dp), allocatable :: x(:, :), vectors(:, :)
    real(dp), dimension(size(samples%value, 2)) :: mean, deviation, values
    real(dp) :: work(64*size(mean)), penalty
    integer :: s, n, sensors, most, info
    cost = huge(1.0_dp)
    n = samples%count
    sensors = size(mean)
    if (allocated(samples%missing) .or. sensors == 1) return
    most = min(sensors, max(1, most_numbers/n))
    penalty = akaike
    mean = [(sum(samples%value(:n, s))/n, s=1, sensors)]
    allocate (x(n, most))
    if (most == sensors) then
      do s = 1, sensors
        x(:, s) = samples%value(:n, s) - mean(s)
      end do
      cost = 0
    else                                          ! the other components cost what noise of their power does
      allocate (vectors(sensors, sensors))
      call dgemm('T', 'N', sensors, sensors, n, 1.0_dp, samples%value, size(samples%value, 1), samples%value, &
        & size(samples%value, 1), 0.0_dp, vectors, sensors)
      vectors = vectors/n - spread(mean, 1, sensors)*spread(mean, 2, sensors)
      deviation = sqrt([(vectors(s, s), s=1, sensors)])
      vectors = vectors/(spread(deviation, 1, sensors)*spread(deviation, 2, sensors))
      call dsyev('V', 'U', sensors, vectors, sensors, values, work, size(work), info)
      if (info /= 0) return
      vectors = vectors/spread(deviation, 2, sensors)
      associate (own => vectors(:, sensors - most + 1:))
        call dgemm('N', 'N', n, most, sensors, 1.0_dp, samples%value, size(samples%value, 1), own, sensors, 0.0_dp, x, n)
        do s = 1, most
          x(:, s) = x(:, s) - dot_product(mean, own(:, s))
        end do
      end associate
      cost = n*(sum(2*log(deviation)) + sum(log(max(values(:sensors - most), tiny(1.0_dp))))) &
        & + 0.5_dp*penalty*(sensors*(sensors - 1) - most*(most - 1))
    end if
    cost = cost + vector_noise_cost(x, most_orders(samples, n/(10*most), most), penalty)
  end function cost_of_shared_motion

  pure integer function most_orders(samples, highest, sensors) result(order)
    !! The highest order of noise alone that takes a fraction of a second, each sample being predicted from so many sensors.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: highest, sensors
    real(dp), parameter :: products = 2.0e8_dp
    order = min(highest, max(least_colour, int(products/(real(size(samples%value), dp)*sensors))))
  end function most_orders

end module bw_noise_alone
